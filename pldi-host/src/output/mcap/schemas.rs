//! Definitions of the messages, from which viewers learn how to read them.

/// Fields of each message, as ROS 2 has them since Humble (vision_msgs since 4.0); constants are left out.
const MESSAGES: &[(&str, &str)] = &[
    ("builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"),
    ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"),
    ("geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"),
    ("geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"),
    ("geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"),
    ("geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"),
    ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"),
    (
        "sensor_msgs/CameraInfo",
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n\
         float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
    ),
    ("sensor_msgs/CompressedImage", "std_msgs/Header header\nstring format\nuint8[] data\n"),
    (
        "sensor_msgs/Image",
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\n\
         uint8[] data\n",
    ),
    (
        "sensor_msgs/RegionOfInterest",
        "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
    ),
    ("std_msgs/ColorRGBA", "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n"),
    ("std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"),
    ("vision_msgs/BoundingBox3D", "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n"),
    (
        "vision_msgs/Detection3D",
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\nvision_msgs/BoundingBox3D bbox\n\
         string id\n",
    ),
    ("vision_msgs/Detection3DArray", "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n"),
    ("vision_msgs/ObjectHypothesis", "string class_id\nfloat64 score\n"),
    (
        "vision_msgs/ObjectHypothesisWithPose",
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n",
    ),
    (
        "visualization_msgs/Marker",
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n\
         geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n\
         bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n\
         sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n\
         string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n",
    ),
    ("visualization_msgs/MarkerArray", "visualization_msgs/Marker[] markers\n"),
    ("visualization_msgs/MeshFile", "string filename\nuint8[] data\n"),
    ("visualization_msgs/UVCoordinate", "float32 u\nfloat32 v\n"),
];

/// Line between a message and those that it is made of.
const SEPARATOR: &str = "================================================================================\n";

/// The definition of message `name` (`sensor_msgs/Image`) followed by those of all messages it is made of, in the form
/// `ros2msg`. Empty for a name that is not in the table.
pub(super) fn definition(name: &str) -> String {
    let mut names = vec![name];
    let mut text = String::new();
    let mut next = 0;
    while let Some(name) = names.get(next) {
        let fields = MESSAGES.iter().find(|(known, _)| known == name).map_or("", |(_, fields)| fields);
        if next > 0 {
            text += &format!("{SEPARATOR}MSG: {name}\n");
        }
        text += fields;
        for part in parts(fields) {
            if !names.contains(&part) {
                names.push(part);
            }
        }
        next += 1;
    }
    text
}

/// The messages among the types of fields.
fn parts(fields: &str) -> impl Iterator<Item = &str> {
    fields.lines().filter_map(|line| line.split(['[', ' ']).next()).filter(|name| name.contains('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_there_once() {
        for (name, fields) in MESSAGES {
            for part in parts(fields) {
                assert!(MESSAGES.iter().any(|(known, _)| *known == part), "{part} in {name}");
            }
            let text = definition(name);
            let mut named: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("MSG: ")).collect();
            let count = named.len();
            named.sort_unstable();
            named.dedup();
            assert_eq!((named.len(), named.contains(name)), (count, false), "{text}");
        }
    }

    #[test]
    fn parts_follow_in_the_order_they_are_met() {
        let line = "=".repeat(80);
        let expected = format!(
            "std_msgs/Header header\nstring format\nuint8[] data\n{line}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time \
             stamp\nstring frame_id\n{line}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        );
        assert_eq!(definition("sensor_msgs/CompressedImage"), expected);
    }
}
