"""Bags and MCAP files of a recording's frames, written by the formats' own Python libraries.

    python tests/ros/write.py RECORDING OUT

RECORDING is a folder in the TUM layout with associations.txt and camera_info.yaml. OUT gets one file for each container,
compression, encoding and mishap that the tests name, and folders `NAME.colour` with what OpenCV makes of the encodings
that lose colour. Stamps are those of the recording, 1700000000 s later: a header without a stamp has 0.
"""

import re
import sys
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as Ros2Writer
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Rosbag2Writer
from rosbags.typesys import Stores, get_typestore

EPOCH = 1_700_000_000
IMAGE, COMPRESSED, INFO = (f"sensor_msgs/msg/{name}" for name in ("Image", "CompressedImage", "CameraInfo"))
COLOUR_TOPIC, DEPTH_TOPIC, INFO_TOPIC = "/camera/rgb/image_raw", "/camera/depth_registered/image_raw", "/camera/depth_registered/camera_info"


class Recording:
    """The frames of a folder: stamps in nanoseconds, BGR, and depth in mm."""

    def __init__(self, folder):
        info = (folder / "camera_info.yaml").read_text()
        numbers = lambda key: [float(x) for x in re.search(key + r":[^\[]*?data: \[(.*?)\]", info, re.S)[1].split(",")]
        self.size = tuple(int(re.search(key + r": (\d+)", info)[1]) for key in ("image_width", "image_height"))
        self.k, self.d = np.array(numbers("camera_matrix")), np.array(numbers("distortion_coefficients"))
        self.frames = []
        for line in (folder / "associations.txt").read_text().splitlines():
            if line and not line.startswith("#"):
                _, colour, stamp, depth = line.split()
                bgr = cv2.imread(str(folder / colour), cv2.IMREAD_COLOR)
                mm = cv2.imread(str(folder / depth), cv2.IMREAD_UNCHANGED)
                self.frames.append((EPOCH * 10**9 + round(float(stamp) * 1e9), bgr, mm))


class Messages:
    """Messages of one version of ROS."""

    def __init__(self, ros1):
        self.ros1 = ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)

    def header(self, stamp):
        seq = {"seq": 7} if self.ros1 else {}
        time = self.store.types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
        return self.store.types["std_msgs/msg/Header"](stamp=time, frame_id="camera", **seq)

    def image(self, stamp, encoding, pixels, big=False, padding=0):
        rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(pixels.shape[0], -1)
        rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=0xEE)
        return IMAGE, self.store.types[IMAGE](
            header=self.header(stamp), height=pixels.shape[0], width=pixels.shape[1], encoding=encoding,
            is_bigendian=int(big), step=rows.shape[1], data=rows.reshape(-1))

    def compressed(self, stamp, form, data):
        return COMPRESSED, self.store.types[COMPRESSED](header=self.header(stamp), format=form, data=data)

    def info(self, stamp, recording):
        types, (width, height) = self.store.types, recording.size
        roi = types["sensor_msgs/msg/RegionOfInterest"](x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
        k, names = recording.k, ("D", "K", "R", "P") if self.ros1 else ("d", "k", "r", "p")
        p = np.insert(k, [3, 6, 9], 0.0)
        matrices = dict(zip(names, (recording.d, k, np.eye(3).reshape(-1), p)))
        return INFO, types[INFO](header=self.header(stamp), height=height, width=width, distortion_model="plumb_bob",
                                 binning_x=0, binning_y=0, roi=roi, **matrices)


def png(pixels):
    return cv2.imencode(".png", pixels)[1].reshape(-1)


def metres(mm):
    """As drivers send them: NaN where there is none."""
    return np.where(mm == 0, np.nan, mm.astype(np.float32) / np.float32(1000)).astype(np.float32)


def uyvy(bgr):
    """Two pixels in four bytes, the chroma of the first for both; in the shape of a two-channel image."""
    yuv = limited_yuv(bgr)
    out = np.empty(bgr.shape[:2] + (2,), np.uint8)
    out[:, :, 1] = yuv[:, :, 0]
    out[:, 0::2, 0], out[:, 1::2, 0] = yuv[:, 0::2, 1], yuv[:, 0::2, 2]
    return out


def limited_yuv(bgr):
    """ITU-R BT.601 in its limited range."""
    to_yuv = np.array([[24.966, 128.553, 65.481], [112.0, -74.203, -37.797], [-18.214, -93.786, 112.0]]) / 255
    return np.clip(np.rint(bgr @ to_yuv.T + [16, 128, 128]), 0, 255).astype(np.uint8)


def mosaic(bgr, pattern):
    out = np.empty(bgr.shape[:2], np.uint8)
    for i, colour in enumerate(pattern):
        y, x = divmod(i, 2)
        out[y::2, x::2] = bgr[y::2, x::2, "bgr".index(colour)]
    return out


def inverse_depth(mm):
    """As compressed_depth_image_transport quantises metres: its two numbers, and 16 bits a pixel."""
    z0, far = np.float32(100), np.float32(10)
    a = z0 * (z0 + 1)
    b = 1 - a / far
    with np.errstate(divide="ignore", invalid="ignore"):
        quantised = np.where(mm > 0, a / (mm.astype(np.float32) / 1000) + b, 0)
    return a, b, quantised.astype(np.uint16)


def compressed_depth(image, a=0.0, b=0.0):
    head = np.array([0], "<i4").tobytes() + np.array([a, b], "<f4").tobytes()
    return np.concatenate([np.frombuffer(head, np.uint8), png(image)])


def stream(recording, messages, colour, depth):
    """Topic, type, time of recording and message, in the order of recording: the calibration first."""
    for number, (stamp, bgr, mm) in enumerate(recording.frames):
        noise = messages.header(stamp)
        yield "/noise", "std_msgs/msg/Header", stamp, noise
        yield INFO_TOPIC, *(lambda t, m: (t, stamp, m))(*messages.info(stamp, recording))
        topics = [(COLOUR_TOPIC, colour, bgr, stamp + 3_000_000), (DEPTH_TOPIC, depth, mm, stamp)]
        for topic, make, pixels, time in topics if number % 2 else reversed(topics):
            type_name, message = make(messages, time, pixels)
            suffix = "" if type_name == IMAGE else "/compressed" if topic == COLOUR_TOPIC else "/compressedDepth"
            yield topic + suffix, type_name, time, message


def raw(encoding, change=lambda pixels: pixels, **options):
    return lambda messages, stamp, pixels: messages.image(stamp, encoding, change(pixels), **options)


def packed(form, pack):
    return lambda messages, stamp, pixels: messages.compressed(stamp, form, pack(pixels))


RGB, BGR = raw("rgb8", lambda p: p[:, :, ::-1]), raw("bgr8")
MM, METRES = raw("16UC1"), raw("32FC1", metres)


def write_mcap(path, recording, colour, depth, compression=CompressionType.ZSTD, indexed=True, ros1=False,
               little=True, **options):
    messages = Messages(ros1)
    if not indexed:
        options |= dict(index_types=IndexType.NONE, use_statistics=False, use_summary_offsets=False,
                        repeat_channels=False, repeat_schemas=False)
    with open(path, "wb") as out:
        writer, channels = McapWriter(out, compression=compression, **options), {}
        writer.start(profile="ros1" if ros1 else "ros2", library="test")
        writer.add_attachment(0, 0, "note.txt", "text/plain", b"nothing" * 20000)
        for topic, type_name, time, message in stream(recording, messages, colour, depth):
            if topic not in channels:
                definition, _ = messages.store.generate_msgdef(type_name, ros_version=1 if ros1 else 2)
                name = type_name.replace("/msg/", "/") if ros1 else type_name
                schema = writer.register_schema(name, "ros1msg" if ros1 else "ros2msg", definition.encode())
                channels[topic] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schema)
            if ros1:
                data = messages.store.serialize_ros1(message, type_name)
            else:
                data = messages.store.serialize_cdr(message, type_name, little_endian=little)
            writer.add_message(channels[topic], time, bytes(data), time)
        writer.finish()


def write_with_ros2_support(path, recording, colour, depth):
    """The same through mcap-ros2-support's own serialisation."""
    plain = lambda m: {s: plain(getattr(m, s)) for s in m.__dataclass_fields__ if not s.startswith("_")} \
        if hasattr(m, "__dataclass_fields__") else m.tobytes() if getattr(m, "dtype", None) == np.uint8 \
        else m.tolist() if hasattr(m, "tolist") else m
    messages, schemas = Messages(False), {}
    with open(path, "wb") as out:
        writer = Ros2Writer(out)
        for topic, type_name, time, message in stream(recording, messages, colour, depth):
            if type_name not in schemas:
                definition, _ = messages.store.generate_msgdef(type_name, ros_version=2)
                schemas[type_name] = writer.register_msgdef(type_name, definition)
            writer.write_message(topic, schemas[type_name], plain(message), time, time)
        writer.finish()


def write_rosbag2(path, recording, colour, depth):
    """By rosbags: a folder with the MCAP file and its metadata."""
    messages = Messages(False)
    with Rosbag2Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = {}
        for topic, type_name, time, message in stream(recording, messages, colour, depth):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, type_name, typestore=messages.store)
            writer.write(connections[topic], time, messages.store.serialize_cdr(message, type_name))


def write_bag(path, recording, colour, depth, compression=None):
    messages = Messages(True)
    writer = BagWriter(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        connections = {}
        for topic, type_name, time, message in stream(recording, messages, colour, depth):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, type_name, typestore=messages.store)
            writer.write(connections[topic], time, messages.store.serialize_ros1(message, type_name))


def write_colour(folder, recording, decode):
    folder.mkdir()
    for number, (_, bgr, _) in enumerate(recording.frames):
        cv2.imwrite(str(folder / f"{number:06}.png"), decode(bgr))


def main():
    source, out = map(Path, sys.argv[1:])
    out.mkdir(exist_ok=True)
    recording = Recording(source)
    png_depth = packed("16UC1; compressedDepth png", compressed_depth)
    png_colour = packed("bgr8; png compressed bgr8", png)
    # Lossless, in all containers and compressions.
    write_with_ros2_support(out / "ros2-support.mcap", recording, RGB, MM)
    write_mcap(out / "lz4.mcap", recording, BGR, METRES, CompressionType.LZ4)
    write_mcap(out / "none.mcap", recording, raw("rgba8", lambda p: cv2.cvtColor(p, cv2.COLOR_BGR2RGBA), padding=5),
               raw("16UC1", lambda p: p.astype(">u2"), big=True, padding=6), CompressionType.NONE, little=False)
    write_mcap(out / "unchunked.mcap", recording, raw("bgra8", lambda p: cv2.cvtColor(p, cv2.COLOR_BGR2BGRA)),
               raw("mono16"), use_chunking=False)
    write_mcap(out / "unindexed.mcap", recording, png_colour, png_depth, indexed=False)
    write_mcap(out / "ros1.mcap", recording, raw("8UC3"), METRES, ros1=True)
    write_rosbag2(out / "rosbag2", recording, png_colour, packed("16UC1; png compressed ", png))
    write_bag(out / "none.bag", recording, RGB, raw("32FC1", lambda p: metres(p).astype(">f4"), big=True))
    write_bag(out / "lz4.bag", recording, png_colour, png_depth, BagWriter.CompressionFormat.LZ4)
    write_bag(out / "bz2.bag", recording, BGR, MM, BagWriter.CompressionFormat.BZ2)
    # Mishaps: within the third frame's messages; a byte in the second frame's chunk; a bag whose recorder was killed.
    write_mcap(out / "small.mcap", recording, RGB, MM, chunk_size=1000)
    whole = (out / "small.mcap").read_bytes()
    marks = chunk_starts(whole)
    (out / "truncated.mcap").write_bytes(whole[: (marks[-1] + len(whole)) // 2])
    (out / "damaged.mcap").write_bytes(flipped(whole, marks[len(marks) // 2] + 2000))
    whole = (out / "none.bag").read_bytes()
    (out / "active.bag").write_bytes(unindexed(whole)[: int(len(whole) * 0.8)])
    # Encodings that lose something, with what OpenCV reads.
    half = lambda bgr: cv2.cvtColor(uyvy(bgr), cv2.COLOR_YUV2BGR_UYVY)
    write_mcap(out / "uyvy.mcap", recording, raw("yuv422", uyvy), MM)
    write_mcap(out / "yuyv.mcap", recording, raw("yuv422_yuy2", lambda p: uyvy(p)[:, :, ::-1]), MM)
    for name in ("uyvy", "yuyv"):
        write_colour(out / f"{name}.colour", recording, half)
    bayer = {"rggb": cv2.COLOR_BayerRGGB2BGR, "bggr": cv2.COLOR_BayerBGGR2BGR, "gbrg": cv2.COLOR_BayerGBRG2BGR,
             "grbg": cv2.COLOR_BayerGRBG2BGR}
    for pattern, code in bayer.items():
        write_mcap(out / f"{pattern}.mcap", recording, raw(f"bayer_{pattern}8", lambda p: mosaic(p, pattern)), MM)
        write_colour(out / f"{pattern}.colour", recording, lambda p: cv2.cvtColor(mosaic(p, pattern), code))
    jpeg = lambda bgr: cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].reshape(-1)
    inverse = lambda mm: compressed_depth(*(lambda a, b, q: (q, a, b))(*inverse_depth(mm)))
    write_bag(out / "jpeg.bag", recording, packed("rgb8; jpeg compressed bgr8", jpeg),
              packed("32FC1; compressedDepth png", inverse))
    write_colour(out / "jpeg.colour", recording, lambda p: cv2.imdecode(jpeg(p), cv2.IMREAD_COLOR))
    write_mcap(out / "mono8.mcap", recording, raw("mono8", lambda p: cv2.cvtColor(p, cv2.COLOR_BGR2GRAY)), MM)
    write_colour(out / "mono8.colour", recording, lambda p: cv2.cvtColor(cv2.cvtColor(p, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR))


def chunk_starts(whole):
    """Where an MCAP file's chunks begin."""
    at, found = 8, []
    while at < len(whole) - 8:
        if whole[at] == 6:
            found.append(at)
        at += 9 + int.from_bytes(whole[at + 1 : at + 9], "little")
    return found


def flipped(whole, at):
    return whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :]


def unindexed(bag):
    """A bag's header says where its index is once the bag is finished."""
    at = bag.index(b"index_pos=") + len(b"index_pos=")
    return bag[:at] + bytes(8) + bag[at + 8 :]


if __name__ == "__main__":
    main()
