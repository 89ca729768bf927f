/*
 * pldi: recognises furniture-sized objects from one RGB-D frame, in integers, without heap.
 *
 * Made of the Rust sources by `cargo xtask capi --renew`: do not edit.
 *
 * A pldi_pipeline holds what is computed once, a pldi_workspace a frame on its way and its results, a pldi_templates the
 * known objects. The caller owns the memory of all three; the library has no memory of its own that changes. So any
 * function may be called from any thread, core or interrupt, as long as no two calls use one object at a time and one of
 * them changes it. Pipelines and templates are changed by their own init or open function alone: cores may share them.
 *
 * Of every function but those that return a text, a size or a pointer the result is a pldi_status. Pointers that are NULL or
 * misaligned, memory that is too small, buffers that lie in the workspace, objects that were not initialised and calls in
 * the wrong order are errors, and leave everything as it was unless said otherwise. What no library can check is the caller's duty:
 * that a pointer which is not NULL points to as many bytes as the call says, and that nobody else writes there meanwhile.
 *
 * Units: numbers in 1/65536 are called Q16. Lengths that go in are in 1/128 mm, lengths that come out in mm or 1/128 mm, as
 * said there. The macros below turn constants into these units at compile time; they are not meant for variables,
 * because that would take floating point.
 */

#ifndef PLDI_H
#define PLDI_H

#include <stddef.h>
#include <stdint.h>
/** Version of the header as one number, to be compared with pldi_version(). */
#define PLDI_VERSION ((uint32_t)((PLDI_VERSION_MAJOR << 16) | (PLDI_VERSION_MINOR << 8) | PLDI_VERSION_PATCH))

/** Defines memory for an object: static PLDI_MEMORY(memory, PLDI_WORKSPACE_SIZE); */
#define PLDI_MEMORY(name, size) uint64_t name[((size) + 7) / 8]

/** Millimetres in 1/128 mm. For variables as well, if they are integers. */
#define PLDI_MM(mm) ((int32_t)((mm) * 128))

/** Pixels in Q16, for constants. */
#define PLDI_PIXELS(pixels) ((int32_t)((pixels) * 65536.0 + 0.5))

/** Degrees in 2^-28 radians, for constants. */
#define PLDI_DEGREES(degrees) ((int32_t)((degrees) * 4685082.5363))

/** A share of 1 in Q16, for constants. */
#define PLDI_SHARE(share) ((int32_t)((share) * 65536.0 + 0.5))

/** Square metres in 25 mm^2, for constants. */
#define PLDI_SQUARE_METRES(area) ((uint32_t)((area) * 40000.0 + 0.5))

/**
 * Columns of a frame.
 */
#define PLDI_WIDTH 320

/**
 * Rows of a frame.
 */
#define PLDI_HEIGHT 240

/**
 * Version of the header: the first number. Versions with equal first numbers (while it is 0: equal first two) fit together.
 */
#define PLDI_VERSION_MAJOR 0

/**
 * Version of the header: the second number.
 */
#define PLDI_VERSION_MINOR 1

/**
 * Version of the header: the third number.
 */
#define PLDI_VERSION_PATCH 0

/**
 * Bytes of a pldi_pipeline on every target. What the tables do not need is kept for later versions.
 */
#define PLDI_PIPELINE_SIZE 5120

/**
 * Alignment of a pldi_pipeline.
 */
#define PLDI_PIPELINE_ALIGN 8

/**
 * Bytes of a pldi_workspace on every target: 480 KiB. What the images do not need is kept for later versions.
 */
#define PLDI_WORKSPACE_SIZE 491520

/**
 * Alignment of a pldi_workspace.
 */
#define PLDI_WORKSPACE_ALIGN 8

/**
 * Words of a pldi_templates.
 */
#define PLDI_TEMPLATES_WORDS 20

/**
 * The most sensor rows that belong to a row of a frame: 2560 x 1920 pixels.
 */
#define PLDI_MAX_REDUCTION 8

/**
 * The most detections of a frame.
 */
#define PLDI_MAX_DETECTIONS 32

/**
 * The most rejected clusters of a frame.
 */
#define PLDI_MAX_REJECTED 192

/**
 * The most hypotheses of a detection.
 */
#define PLDI_MAX_HYPOTHESES 5

/**
 * No class: the template set is empty.
 */
#define PLDI_NO_CLASS 65535

/**
 * What a call came to. A frame without floor or objects is PLDI_OK.
 */
enum pldi_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * All went well.
     */
    PLDI_OK = 0,
    /**
     * A pointer is NULL that must not be.
     */
    PLDI_ERROR_NULL = 1,
    /**
     * A pointer is not a multiple of its type's alignment.
     */
    PLDI_ERROR_ALIGNMENT = 2,
    /**
     * The memory for an object is too small.
     */
    PLDI_ERROR_MEMORY = 3,
    /**
     * Two buffers share bytes: an input or an output lies in the workspace.
     */
    PLDI_ERROR_OVERLAP = 4,
    /**
     * An object was not initialised, was overwritten, or comes from another version of the library.
     */
    PLDI_ERROR_NOT_INITIALISED = 5,
    /**
     * The parameters were not filled by pldi_default_params of this version.
     */
    PLDI_ERROR_VERSION = 6,
    /**
     * Calls in the wrong order.
     */
    PLDI_ERROR_ORDER = 7,
    /**
     * The intrinsics are out of range, or for images of another size than 320x240.
     */
    PLDI_ERROR_INTRINSICS = 8,
    /**
     * The range of valid depths is empty or begins at 0.
     */
    PLDI_ERROR_DEPTH_RANGE = 9,
    /**
     * The relation of raw disparity and depth is of no use.
     */
    PLDI_ERROR_DISPARITY = 10,
    /**
     * A parameter of the filter is out of range.
     */
    PLDI_ERROR_FILTER = 11,
    /**
     * A parameter of the floor is out of range.
     */
    PLDI_ERROR_FLOOR = 12,
    /**
     * A parameter of the sensory area is out of range.
     */
    PLDI_ERROR_AREA = 13,
    /**
     * A limit of the candidates is out of range.
     */
    PLDI_ERROR_LIMITS = 14,
    /**
     * A parameter of the view is out of range.
     */
    PLDI_ERROR_VIEW = 15,
    /**
     * An unknown number in place of a format or a mode.
     */
    PLDI_ERROR_FORMAT = 16,
    /**
     * A frame or a row has another number of values than its format asks for.
     */
    PLDI_ERROR_LENGTH = 17,
    /**
     * The template bytes are fewer than their header says.
     */
    PLDI_ERROR_TEMPLATES_CUT = 18,
    /**
     * The bytes are no template file.
     */
    PLDI_ERROR_TEMPLATES_FORMAT = 19,
    /**
     * The template file is of a version that this library does not read.
     */
    PLDI_ERROR_TEMPLATES_VERSION = 20,
    /**
     * The template bytes were changed: the checksum does not fit.
     */
    PLDI_ERROR_TEMPLATES_CHECKSUM = 21,
    /**
     * A field of the template file is out of range.
     */
    PLDI_ERROR_TEMPLATES_FIELD = 22,
    /**
     * The templates were made with other view parameters than the pipeline's.
     */
    PLDI_ERROR_TEMPLATES_PARAMETERS = 23,
    /**
     * The templates hold floats.
     */
    PLDI_ERROR_TEMPLATES_ENCODING = 24,
    /**
     * The results were made with another template set.
     */
    PLDI_ERROR_TEMPLATES_OTHER = 25,
    /**
     * The frame has more clusters or contour points than there is room for.
     */
    PLDI_ERROR_CAPACITY = 26,
    /**
     * The array for the results is too short; it was filled as far as it goes.
     */
    PLDI_ERROR_ARRAY_SHORT = 27,
    /**
     * None of the above.
     */
    PLDI_ERROR_INTERNAL = 28,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pldi_status pldi_status;
#else
typedef int32_t pldi_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What guides the filter that reconstructs the depth.
 */
enum pldi_filter_kind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Colour and depth; depth alone where there is no colour.
     */
    PLDI_FILTER_JOINT = 0,
    /**
     * Depth alone.
     */
    PLDI_FILTER_BILATERAL = 1,
    /**
     * No filter: the measured depth as it is.
     */
    PLDI_FILTER_NONE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pldi_filter_kind pldi_filter_kind;
#else
typedef uint32_t pldi_filter_kind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Where the floor comes from.
 */
enum pldi_floor_mode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Found in each frame: see pldi_floor_search.
     */
    PLDI_FLOOR_SEARCH = 0,
    /**
     * The camera's pose is known: see pldi_pose.
     */
    PLDI_FLOOR_POSE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pldi_floor_mode pldi_floor_mode;
#else
typedef uint32_t pldi_floor_mode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the values of a row of depth are.
 */
enum pldi_depth_format
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Millimetres, 0 = no reading.
     */
    PLDI_DEPTH_MM = 0,
    /**
     * Raw disparity; pldi_params says what it means.
     */
    PLDI_DEPTH_RAW = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pldi_depth_format pldi_depth_format;
#else
typedef uint32_t pldi_depth_format;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What the values of a row of colour are.
 */
enum pldi_colour_format
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * 3 bytes a pixel: red, green, blue.
     */
    PLDI_COLOUR_RGB888 = 0,
    /**
     * A uint16_t a pixel: red in the upper five bits, green in the middle six, blue in the lower five.
     */
    PLDI_COLOUR_RGB565 = 1,
    /**
     * 4 bytes for two pixels: Y U Y V, BT.601 with limited range.
     */
    PLDI_COLOUR_YUYV = 2,
    /**
     * 1 byte a pixel of a mosaic: red green, green blue. An even number of rows.
     */
    PLDI_COLOUR_BAYER_RGGB = 3,
    /**
     * A mosaic: green red, blue green (Kinect v1).
     */
    PLDI_COLOUR_BAYER_GRBG = 4,
    /**
     * A mosaic: green blue, red green.
     */
    PLDI_COLOUR_BAYER_GBRG = 5,
    /**
     * A mosaic: blue green, green red.
     */
    PLDI_COLOUR_BAYER_BGGR = 6,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pldi_colour_format pldi_colour_format;
#else
typedef uint32_t pldi_colour_format;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * Why a cluster is no object: the first reason that holds.
 */
enum pldi_rejection
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Too few pixels to be a surface.
     */
    PLDI_REJECTED_NOISE = 0,
    /**
     * It reaches the border of the sensory area or of the image: only a part of it is seen.
     */
    PLDI_REJECTED_AT_BORDER = 1,
    /**
     * Its footprint or height is below the limits.
     */
    PLDI_REJECTED_TOO_SMALL = 2,
    /**
     * Its footprint is above the limits.
     */
    PLDI_REJECTED_TOO_LARGE = 3,
    /**
     * Another cluster stands in front of it.
     */
    PLDI_REJECTED_OCCLUDED = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum pldi_rejection pldi_rejection;
#else
typedef uint32_t pldi_rejection;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * What is computed once for a camera and a set of parameters. Only pldi_pipeline_init writes to it: afterwards any number of
 * workspaces, on any number of cores, may use it. It holds no pointers.
 */
typedef struct pldi_pipeline pldi_pipeline;

/**
 * The memory of a frame on its way, and its results. It holds no pointers.
 */
typedef struct pldi_workspace pldi_workspace;

/**
 * How raw disparity becomes depth: z = scale / (offset - disparity), in mm.
 */
typedef struct pldi_disparity {
    /**
     * Focal length (px) times baseline (mm) times disparity steps per pixel. Kinect v1: 580 * 75 * 8.
     */
    uint32_t scale;
    /**
     * Disparity of a point at infinity, in steps. Kinect v1: 1090.
     */
    uint16_t offset;
    /**
     * From this disparity on there is no reading. Kinect v1: 2047.
     */
    uint16_t none;
} pldi_disparity;

/**
 * A pinhole camera. Focal lengths and principal point in 1/65536 pixel (PLDI_PIXELS).
 */
typedef struct pldi_intrinsics {
    /**
     * Width in pixels of the images that the numbers are for: PLDI_WIDTH.
     */
    uint16_t width;
    /**
     * Height in pixels of the images that the numbers are for: PLDI_HEIGHT.
     */
    uint16_t height;
    /**
     * Focal length, horizontally.
     */
    int32_t fx;
    /**
     * Focal length, vertically.
     */
    int32_t fy;
    /**
     * Column of the principal point, from the centre of the leftmost column.
     */
    int32_t cx;
    /**
     * Row of the principal point, from the centre of the topmost row.
     */
    int32_t cy;
} pldi_intrinsics;

/**
 * Reconstruction of the depth.
 */
typedef struct pldi_filter {
    /**
     * One of pldi_filter_kind.
     */
    uint32_t kind;
    /**
     * Spatial standard deviation in 1/65536 pixel: 0.5 to 100 pixels.
     */
    uint32_t sigma_space;
    /**
     * Standard deviation of the sum of the three channels' differences, in 1/65536: 1 to 1000.
     */
    uint32_t sigma_colour;
    /**
     * Standard deviation of the depth in 1/128 mm (PLDI_MM): 1 to 250 mm.
     */
    uint32_t sigma_depth;
    /**
     * Passes over rows and columns, 1 to 5.
     */
    uint32_t iterations;
    /**
     * A pixel stays without depth where the filtered mask is not above this, in 2^-27: 1e-6 to 0.999.
     */
    uint32_t weight_floor;
} pldi_filter;

/**
 * The camera above the floor.
 */
typedef struct pldi_pose {
    /**
     * Height above the floor in 1/128 mm (PLDI_MM): 1 cm to 10 m.
     */
    int32_t height;
    /**
     * How far it looks down, in 2^-28 radians (PLDI_DEGREES); 0 is level. Within a quarter turn.
     */
    int32_t pitch;
    /**
     * How far it is turned clockwise about its axis, in 2^-28 radians (PLDI_DEGREES). Within a quarter turn.
     */
    int32_t roll;
} pldi_pose;

/**
 * The search for the floor: random samples of three points, the same ones for the same seed.
 */
typedef struct pldi_floor_search {
    /**
     * Seed of the random numbers.
     */
    uint32_t seed;
    /**
     * Samples that are drawn, 1 to 10,000.
     */
    uint32_t samples;
    /**
     * Tolerance at the camera in 1/128 mm (PLDI_MM): 0.1 mm to 0.5 m.
     */
    int32_t tolerance;
    /**
     * Growth of the tolerance with the squared depth, in 1/1024 mm per square metre: up to 0.5 m.
     */
    int32_t tolerance_per_z2;
    /**
     * Smallest height of the camera above the floor in 1/128 mm (PLDI_MM): 1 cm to 10 m.
     */
    int32_t height_min;
    /**
     * Largest height.
     */
    int32_t height_max;
    /**
     * Smallest pitch in 2^-28 radians (PLDI_DEGREES), within 1.6.
     */
    int32_t pitch_min;
    /**
     * Largest pitch.
     */
    int32_t pitch_max;
    /**
     * From this pitch on a plane counts for a fifth.
     */
    int32_t steep;
    /**
     * Largest tilt to a side in 2^-28 radians, 0 to 1.6.
     */
    int32_t tilt;
    /**
     * Share of the points with depth that must lie on the floor, in 1/65536.
     */
    int32_t support;
    /**
     * Points beyond this depth in 1/128 mm (PLDI_MM) are not looked at: 0.1 m to 100 m.
     */
    int32_t far;
} pldi_floor_search;

/**
 * The sensory area: where on the floor objects are looked for.
 */
typedef struct pldi_area {
    /**
     * Nearest distance along the floor in 1/128 mm (PLDI_MM): 0 to 4 m.
     */
    int32_t near;
    /**
     * Farthest distance along the floor in 1/128 mm: 2 cm more than the nearest, up to 4.12 m.
     */
    int32_t far;
    /**
     * Leftmost angle from the direction of view in 2^-28 radians (PLDI_DEGREES): -1.5 to 0.
     */
    int32_t left;
    /**
     * Rightmost angle: 0 to 1.5.
     */
    int32_t right;
} pldi_area;

/**
 * What a cluster of pixels must be like to be a candidate.
 */
typedef struct pldi_limits {
    /**
     * Fewest pixels; below, it is noise.
     */
    uint32_t min_pixels;
    /**
     * Smallest area of the footprint in 25 mm^2 (PLDI_SQUARE_METRES).
     */
    uint32_t area_min;
    /**
     * Largest area of the footprint, up to 10,000 m^2.
     */
    uint32_t area_max;
    /**
     * Smallest length of the footprint's contour in 1/128 mm (PLDI_MM).
     */
    int32_t length_min;
    /**
     * Largest length of the footprint's contour, up to 10 km.
     */
    int32_t length_max;
    /**
     * Smallest height above the floor in 1/128 mm: up to 10 m.
     */
    int32_t min_top;
    /**
     * Largest share of the contour that may lie behind another cluster, in 1/65536.
     */
    uint32_t max_occluded;
    /**
     * A cell counts as hidden where more than this share of the cluster's height is, in 1/65536.
     */
    uint32_t hidden;
    /**
     * Pixels within so many columns or rows of the image's left, right or lower border make a cluster reach it.
     */
    uint16_t margin;
} pldi_limits;

/**
 * What the descriptors are made of: as the templates' are, see pldi_params_for_templates.
 */
typedef struct pldi_view {
    /**
     * 0 = the paper's moments, 1 = means of both halves.
     */
    uint32_t descriptor;
    /**
     * 0 = the view fits the object, 1 = it has a fixed side.
     */
    uint32_t framing;
    /**
     * That side in 1/128 mm: 0.1 m to 10 m. Not looked at where the view fits the object.
     */
    int32_t side;
    /**
     * Radius of the normals in 1/8 mm: 5 mm to 500 mm.
     */
    uint16_t radius;
    /**
     * The hash by which templates know these parameters.
     */
    uint32_t hash;
} pldi_view;

/**
 * All parameters, in integers. Fill them with pldi_default_params, then change what is to be changed.
 */
typedef struct pldi_params {
    /**
     * Set by pldi_default_params: tells the library that this was filled, and for which version.
     */
    uint32_t version;
    /**
     * Smallest valid depth in mm, at least 1.
     */
    uint16_t depth_min;
    /**
     * Largest valid depth in mm. Beyond 8191 mm depths saturate.
     */
    uint16_t depth_max;
    /**
     * For rows of raw disparity.
     */
    struct pldi_disparity disparity;
    /**
     * The camera. Default: the Kinect's nominal calibration at 320x240.
     */
    struct pldi_intrinsics intrinsics;
    /**
     * Reconstruction of the depth.
     */
    struct pldi_filter filter;
    /**
     * One of pldi_floor_mode. Default: the search.
     */
    uint32_t floor_mode;
    /**
     * The camera above the floor, for PLDI_FLOOR_POSE. Default: 1.2 m, level.
     */
    struct pldi_pose pose;
    /**
     * The search, for PLDI_FLOOR_SEARCH.
     */
    struct pldi_floor_search search;
    /**
     * Where objects are looked for.
     */
    struct pldi_area area;
    /**
     * Which clusters are candidates.
     */
    struct pldi_limits limits;
    /**
     * What the descriptors are made of.
     */
    struct pldi_view view;
} pldi_params;

/**
 * A template set that has been checked: some words of the caller's, which point into the template file's bytes. May be
 * copied. The bytes must stay where they are; many cores may use one set.
 */
typedef struct pldi_templates {
    /**
     * Not to be touched.
     */
    size_t words[PLDI_TEMPLATES_WORDS];
} pldi_templates;

/**
 * A name within the template file: `length` bytes of UTF-8, not followed by a zero. Valid as long as the file's bytes are.
 */
typedef struct pldi_text {
    /**
     * The first byte; never NULL after a call that gave PLDI_OK.
     */
    const char *text;
    /**
     * Bytes.
     */
    size_t length;
} pldi_text;

/**
 * The depth of a row of the frame: 320 values, or a whole multiple, of which each block's leftmost is taken. A sensor with k
 * times the frame's width gives every k-th of its rows.
 */
typedef struct pldi_depth_row {
    /**
     * One of pldi_depth_format.
     */
    uint32_t format;
    /**
     * The values.
     */
    const uint16_t *values;
    /**
     * How many.
     */
    size_t count;
} pldi_depth_row;

/**
 * The colour of a row of the frame: k rows of k * 320 pixels, whose k x k blocks become a pixel each.
 */
typedef struct pldi_colour_row {
    /**
     * One of pldi_colour_format.
     */
    uint32_t format;
    /**
     * The first row; aligned to 2 bytes for RGB565.
     */
    const void *data;
    /**
     * Bytes of a row's pixels.
     */
    size_t row_bytes;
    /**
     * Bytes from the beginning of a row to that of the next. Not looked at for a single row.
     */
    size_t stride;
    /**
     * Rows: k, 1 to PLDI_MAX_REDUCTION.
     */
    uint32_t rows;
} pldi_colour_row;

/**
 * A possible class of an object.
 */
typedef struct pldi_hypothesis {
    /**
     * Index of the class in the template set, or PLDI_NO_CLASS.
     */
    uint16_t class_id;
    /**
     * Index of the object whose template is nearest.
     */
    uint16_t object;
    /**
     * Number of that template's view.
     */
    uint16_t view;
    /**
     * How much nearer than any other class, in 1/65536: 32768 where two are equally near, 65536 for a perfect fit.
     */
    uint32_t score;
    /**
     * Distance to that template, 0 to 58, in 1/65536.
     */
    uint32_t distance;
    /**
     * Name of the class, in the template file.
     */
    struct pldi_text class_name;
    /**
     * Name of the object, in the template file.
     */
    struct pldi_text object_name;
} pldi_hypothesis;

/**
 * A cluster of pixels that stands on the floor. Lengths in mm; the camera frame has x to the right, y down, z forward.
 */
typedef struct pldi_cluster {
    /**
     * Its number in the frame.
     */
    uint32_t id;
    /**
     * Number of pixels.
     */
    uint32_t pixels;
    /**
     * Centre of the box around it in the camera frame.
     */
    int32_t centre_mm[3];
    /**
     * Width (across the line of sight), height and depth (along it) of that box.
     */
    int32_t size_mm[3];
    /**
     * First column, first row, last column, last row of its pixels.
     */
    uint16_t bbox[4];
} pldi_cluster;

/**
 * An object that was found, and what it most likely is.
 */
typedef struct pldi_detection {
    /**
     * What it most likely is.
     */
    struct pldi_hypothesis best;
    /**
     * Where it stands.
     */
    struct pldi_cluster cluster;
} pldi_detection;

/**
 * A cluster that is no object.
 */
typedef struct pldi_rejected {
    /**
     * One of pldi_rejection.
     */
    uint32_t reason;
    /**
     * Where it is.
     */
    struct pldi_cluster cluster;
} pldi_rejected;

/**
 * The floor plane: points p of the camera frame with normal . p + height = 0.
 */
typedef struct pldi_floor {
    /**
     * 1 where the floor was found, else 0; then there are no clusters either.
     */
    uint32_t found;
    /**
     * Unit vector, pointing up, in 2^-30.
     */
    int32_t normal[3];
    /**
     * Height of the camera above the floor in 1/128 mm.
     */
    int32_t height;
} pldi_floor;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The library's version, major * 65536 + minor * 256 + patch. Compare it with the header's, PLDI_VERSION.
 */
uint32_t pldi_version(void);

/**
 * What a status says, in English: what was wrong and what to do. Never NULL, and never to be freed.
 */
const char *pldi_status_text(int32_t status);

/**
 * Bytes that a pipeline takes: PLDI_PIPELINE_SIZE.
 */
size_t pldi_pipeline_size(void);

/**
 * The alignment of a pipeline: PLDI_PIPELINE_ALIGN.
 */
size_t pldi_pipeline_align(void);

/**
 * Bytes that a workspace takes: PLDI_WORKSPACE_SIZE.
 */
size_t pldi_workspace_size(void);

/**
 * The alignment of a workspace: PLDI_WORKSPACE_ALIGN.
 */
size_t pldi_workspace_align(void);

/**
 * The pipeline of the default parameters, tables and all in constant memory (flash). Linked only where it is called.
 */
const struct pldi_pipeline *pldi_default_pipeline(void);

/**
 * Makes a pipeline in `memory` (of any content), and leaves a pointer to it in `pipeline`. Again for other parameters.
 * After an error *pipeline is NULL.
 */
pldi_status pldi_pipeline_init(void *memory,
                               size_t size,
                               const struct pldi_params *params,
                               struct pldi_pipeline **pipeline);

/**
 * Makes a workspace in `memory` (of any content), and leaves a pointer to it in `workspace`. Once is enough: frames need not be
 * cleaned up after. After an error *workspace is NULL.
 */
pldi_status pldi_init(void *memory,
                      size_t size,
                      struct pldi_workspace **workspace);

/**
 * Fills in the defaults: a Kinect at 320x240 whose pose is found in each frame.
 */
pldi_status pldi_default_params(struct pldi_params *params);

/**
 * Sets params->view to what a template set was made with. Only needed for sets that were built with other options than
 * the defaults.
 */
pldi_status pldi_params_for_templates(struct pldi_params *params, const struct pldi_templates *templates);

/**
 * Checks a template file that lies in memory (flash, best), `size` bytes of any alignment, and makes a set of it. Nothing is
 * copied: the bytes must stay. Reads all of them once, for the checksum. After an error the set is not initialised.
 */
pldi_status pldi_templates_open(struct pldi_templates *templates,
                                const void *bytes,
                                size_t size);

/**
 * The number of templates and of classes; either place may be NULL.
 */
pldi_status pldi_templates_count(const struct pldi_templates *templates, size_t *count, size_t *classes);

/**
 * The name of a class; of length 0 where there is no such class.
 */
pldi_status pldi_templates_class_name(const struct pldi_templates *templates,
                                      uint16_t class_id,
                                      struct pldi_text *name);

/**
 * Takes a whole frame all the way. `depth` has 320 * 240 values in mm, 0 = no reading; `colour` as many pixels of 3 bytes, red, green, blue,
 * registered to the depth, or is NULL. `depth_count` and `colour_bytes` say how much there is.
 *
 * A frame without depth, floor or objects is PLDI_OK: the results say so.
 */
pldi_status pldi_process_frame(const struct pldi_pipeline *pipeline,
                               struct pldi_workspace *workspace,
                               const struct pldi_templates *templates,
                               const uint16_t *depth,
                               size_t depth_count,
                               const uint8_t *colour,
                               size_t colour_bytes);

/**
 * Begins a frame that comes in row by row; what came in of another one is forgotten, and so are its results.
 */
pldi_status pldi_begin_frame(const struct pldi_pipeline *pipeline, struct pldi_workspace *workspace);

/**
 * Takes in the next row: depth, and colour or NULL. When the call returns, the row's buffers are free. After an error the row
 * counts as not pushed.
 */
pldi_status pldi_push_row(const struct pldi_pipeline *pipeline,
                          struct pldi_workspace *workspace,
                          const struct pldi_depth_row *depth,
                          const struct pldi_colour_row *colour);

/**
 * Takes a frame whose 240 rows are in all the way: the same results as of pldi_process_frame.
 */
pldi_status pldi_finish_frame(const struct pldi_pipeline *pipeline,
                              struct pldi_workspace *workspace,
                              const struct pldi_templates *templates);

/**
 * The objects of the last frame, in the order of their clusters: writes at most `capacity` of them to `detections`, and how many there
 * are to `count` (PLDI_ERROR_ARRAY_SHORT where that is more). `templates` is the set that the frame was processed with.
 */
pldi_status pldi_get_detections(const struct pldi_workspace *workspace,
                                const struct pldi_templates *templates,
                                struct pldi_detection *detections,
                                size_t capacity,
                                size_t *count);

/**
 * What an object of the last frame may be, best first: one hypothesis a class, at most PLDI_MAX_HYPOTHESES. `detection` is its place
 * among the detections; for none of them, there are no hypotheses. Array, count and templates as in pldi_get_detections.
 */
pldi_status pldi_get_hypotheses(const struct pldi_workspace *workspace,
                                const struct pldi_templates *templates,
                                size_t detection,
                                struct pldi_hypothesis *hypotheses,
                                size_t capacity,
                                size_t *count);

/**
 * The clusters of the last frame that are no objects, and why. Array and count as in pldi_get_detections.
 */
pldi_status pldi_get_rejected(const struct pldi_workspace *workspace,
                              struct pldi_rejected *rejected,
                              size_t capacity,
                              size_t *count);

/**
 * The floor of the last frame.
 */
pldi_status pldi_get_floor(const struct pldi_workspace *workspace, struct pldi_floor *floor);

/**
 * The reconstructed depth of the last frame: 320 * 240 values in 1/8 mm, 0 = none. In the workspace: valid until its next frame.
 */
pldi_status pldi_get_depth(const struct pldi_workspace *workspace,
                           const uint16_t **depth);

/**
 * N of the last frame's candidates, 65535 = 1, and 0 at all other pixels: 320 * 240 values, or NULL where the frame had no floor. In the
 * workspace: valid until its next frame.
 */
pldi_status pldi_get_n(const struct pldi_workspace *workspace,
                       const uint16_t **n);

/**
 * Why a cluster is no object, in a word or two of English. Never NULL, and never to be freed.
 */
const char *pldi_rejection_text(uint32_t reason);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* PLDI_H */
