/* Every way to call the library wrongly must be an error, and every right one must work. Plain C, linked with the archive for hosts; run
 * under valgrind and with sanitizers. The one argument is the folder with frame.depth, frame.rgb and templates.pldt. */

#include <pldi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PIXELS (PLDI_WIDTH * PLDI_HEIGHT)

static unsigned checks;

static void expect(pldi_status found, pldi_status wanted, const char *call, int line) {
    checks++;
    if (found == wanted) return;
    printf("line %d: %s: %s; wanted: %s\n", line, call, pldi_status_text(found), pldi_status_text(wanted));
    exit(1);
}

static void truth(int holds, const char *what, int line) {
    checks++;
    if (holds) return;
    printf("line %d: not so: %s\n", line, what);
    exit(1);
}

#define EXPECT(wanted, call) expect(call, wanted, #call, __LINE__)
#define OK(call) expect(call, PLDI_OK, #call, __LINE__)
#define TRUE(what) truth((what) != 0, #what, __LINE__)

static uint8_t *contents(const char *folder, const char *name, size_t *size) {
    char path[1024];
    uint8_t *bytes = malloc(1 << 20);
    FILE *file;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "rb");
    TRUE(file != NULL && bytes != NULL);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    /* Exactly as many bytes as there are, so that a read beyond them is seen. */
    return realloc(bytes, *size);
}

/* Memory that is not zero. */
static void *garbage(size_t size) {
    void *memory = malloc(size);
    TRUE(memory != NULL);
    memset(memory, 0xA5, size);
    return memory;
}

static pldi_pipeline *pipeline_of(void *memory, const pldi_params *params) {
    pldi_pipeline *pipeline;
    OK(pldi_pipeline_init(memory, PLDI_PIPELINE_SIZE, params, &pipeline));
    return pipeline;
}

static void versions_and_texts(void) {
    int32_t status;
    uint32_t reason;
    TRUE(pldi_version() == PLDI_VERSION);
    TRUE(pldi_workspace_size() == PLDI_WORKSPACE_SIZE && pldi_workspace_align() == PLDI_WORKSPACE_ALIGN);
    TRUE(pldi_pipeline_size() == PLDI_PIPELINE_SIZE && pldi_pipeline_align() == PLDI_PIPELINE_ALIGN);
    for (status = PLDI_OK; status < PLDI_ERROR_INTERNAL; status++) {
        TRUE(strlen(pldi_status_text(status)) > 5);
        TRUE(strcmp(pldi_status_text(status), pldi_status_text(status + 1)) != 0);
    }
    TRUE(strcmp(pldi_status_text(-1), pldi_status_text(1000)) == 0);
    for (reason = PLDI_REJECTED_NOISE; reason <= PLDI_REJECTED_OCCLUDED; reason++)
        TRUE(strcmp(pldi_rejection_text(reason), pldi_rejection_text(99)) != 0);
}

static void objects(void) {
    void *memory = garbage(PLDI_WORKSPACE_SIZE + 8);
    char *misaligned = (char *)memory + 4;
    pldi_workspace *workspace = (pldi_workspace *)memory, **none = NULL;
    pldi_pipeline *pipeline;
    pldi_params params;
    EXPECT(PLDI_ERROR_NULL, pldi_init(NULL, PLDI_WORKSPACE_SIZE, &workspace));
    TRUE(workspace == NULL);
    EXPECT(PLDI_ERROR_NULL, pldi_init(memory, PLDI_WORKSPACE_SIZE, none));
    EXPECT(PLDI_ERROR_ALIGNMENT, pldi_init(misaligned, PLDI_WORKSPACE_SIZE, &workspace));
    EXPECT(PLDI_ERROR_MEMORY, pldi_init(memory, PLDI_WORKSPACE_SIZE - 1, &workspace));
    EXPECT(PLDI_ERROR_MEMORY, pldi_init(memory, 0, &workspace));
    EXPECT(PLDI_ERROR_OVERLAP, pldi_init(memory, PLDI_WORKSPACE_SIZE, (pldi_workspace **)memory));
    OK(pldi_init(memory, PLDI_WORKSPACE_SIZE, &workspace));
    TRUE((void *)workspace == memory);

    EXPECT(PLDI_ERROR_NULL, pldi_default_params(NULL));
    OK(pldi_default_params(&params));
    EXPECT(PLDI_ERROR_NULL, pldi_pipeline_init(NULL, PLDI_PIPELINE_SIZE, &params, &pipeline));
    EXPECT(PLDI_ERROR_NULL, pldi_pipeline_init(memory, PLDI_PIPELINE_SIZE, NULL, &pipeline));
    EXPECT(PLDI_ERROR_NULL, pldi_pipeline_init(memory, PLDI_PIPELINE_SIZE, &params, NULL));
    EXPECT(PLDI_ERROR_ALIGNMENT, pldi_pipeline_init(misaligned, PLDI_PIPELINE_SIZE, &params, &pipeline));
    EXPECT(PLDI_ERROR_MEMORY, pldi_pipeline_init(memory, PLDI_PIPELINE_SIZE - 1, &params, &pipeline));
    TRUE(pipeline == NULL);
    /* What overwrites a workspace makes it none. */
    OK(pldi_pipeline_init(memory, PLDI_PIPELINE_SIZE, &params, &pipeline));
    EXPECT(PLDI_ERROR_NOT_INITIALISED, pldi_begin_frame(pldi_default_pipeline(), workspace));
    free(memory);
}

static void parameters(void) {
    void *memory = garbage(PLDI_PIPELINE_SIZE);
    pldi_pipeline *pipeline;
    pldi_params good, params;
    OK(pldi_default_params(&good));
#define REFUSED(status, change) \
    do { params = good; change; EXPECT(status, pldi_pipeline_init(memory, PLDI_PIPELINE_SIZE, &params, &pipeline)); } while (0)
    REFUSED(PLDI_ERROR_VERSION, params.version++);
    REFUSED(PLDI_ERROR_VERSION, memset(&params, 0xFF, sizeof params));
    REFUSED(PLDI_ERROR_DEPTH_RANGE, params.depth_min = 0);
    REFUSED(PLDI_ERROR_DEPTH_RANGE, params.depth_max = 0);
    REFUSED(PLDI_ERROR_DISPARITY, params.disparity.scale = 0);
    REFUSED(PLDI_ERROR_INTRINSICS, params.intrinsics.width = 640);
    REFUSED(PLDI_ERROR_INTRINSICS, params.intrinsics.fx = 0);
    REFUSED(PLDI_ERROR_INTRINSICS, params.intrinsics.cy = INT32_MIN);
    REFUSED(PLDI_ERROR_FILTER, params.filter.iterations = 256);
    REFUSED(PLDI_ERROR_FILTER, params.filter.sigma_depth = 0);
    REFUSED(PLDI_ERROR_FORMAT, params.filter.kind = 3);
    REFUSED(PLDI_ERROR_FORMAT, params.floor_mode = 2);
    REFUSED(PLDI_ERROR_FLOOR, params.search.samples = 65537);
    REFUSED(PLDI_ERROR_FLOOR, params.search.height_max = 0);
    REFUSED(PLDI_ERROR_FLOOR, (params.floor_mode = PLDI_FLOOR_POSE, params.pose.pitch = INT32_MAX));
    REFUSED(PLDI_ERROR_AREA, params.area.far = params.area.near);
    REFUSED(PLDI_ERROR_LIMITS, params.limits.hidden = UINT32_MAX);
    REFUSED(PLDI_ERROR_VIEW, params.view.framing = 2);
    REFUSED(PLDI_ERROR_VIEW, params.view.descriptor = 258);
    REFUSED(PLDI_ERROR_VIEW, params.view.radius = 0);
    params = good;
    params.floor_mode = PLDI_FLOOR_POSE;
    params.pose.height = PLDI_MM(1200);
    params.pose.pitch = PLDI_DEGREES(-90);
    params.area.right = PLDI_DEGREES(30);
    params.limits.area_max = PLDI_SQUARE_METRES(2);
    params.limits.hidden = (uint32_t)PLDI_SHARE(0.5);
    pipeline_of(memory, &params);
    free(memory);
}

static void template_bytes(const uint8_t *file, size_t size, pldi_templates *templates) {
    uint8_t *bytes = malloc(size + 1);
    pldi_text name;
    size_t count, classes, i;
    TRUE(bytes != NULL);
    memset(templates, 0xA5, sizeof *templates);
    EXPECT(PLDI_ERROR_NOT_INITIALISED, pldi_templates_count(templates, &count, NULL));
    EXPECT(PLDI_ERROR_NULL, pldi_templates_open(NULL, file, size));
    EXPECT(PLDI_ERROR_NULL, pldi_templates_open(templates, NULL, size));
    EXPECT(PLDI_ERROR_ALIGNMENT, pldi_templates_open((pldi_templates *)((char *)templates + 1), file, size));
    EXPECT(PLDI_ERROR_TEMPLATES_CUT, pldi_templates_open(templates, file, 0));
    EXPECT(PLDI_ERROR_TEMPLATES_CUT, pldi_templates_open(templates, file, 47));
    EXPECT(PLDI_ERROR_TEMPLATES_CUT, pldi_templates_open(templates, file, size - 1));
    EXPECT(PLDI_ERROR_LENGTH, pldi_templates_open(templates, file, SIZE_MAX));
    EXPECT(PLDI_ERROR_OVERLAP, pldi_templates_open(templates, templates, 8));
    /* At an odd address: any will do. */
    memcpy(bytes + 1, file, size);
    OK(pldi_templates_open(templates, bytes + 1, size));
#define BROKEN(status, at, value) \
    do { \
        uint8_t before = bytes[1 + (at)]; \
        bytes[1 + (at)] = (uint8_t)(value); \
        EXPECT(status, pldi_templates_open(templates, bytes + 1, size)); \
        EXPECT(PLDI_ERROR_NOT_INITIALISED, pldi_templates_count(templates, &count, NULL)); \
        bytes[1 + (at)] = before; \
    } while (0)
    BROKEN(PLDI_ERROR_TEMPLATES_FORMAT, 0, 'X');
    BROKEN(PLDI_ERROR_TEMPLATES_VERSION, 4, 77);
    BROKEN(PLDI_ERROR_TEMPLATES_CHECKSUM, size / 2, bytes[1 + size / 2] ^ 1);
    BROKEN(PLDI_ERROR_TEMPLATES_FIELD, 6, 9);
    for (i = 0; i < 48; i++) bytes[1 + i] = (uint8_t)(i * 37);
    EXPECT(PLDI_ERROR_TEMPLATES_FORMAT, pldi_templates_open(templates, bytes + 1, size));
    free(bytes);

    OK(pldi_templates_open(templates, file, size));
    OK(pldi_templates_count(templates, &count, &classes));
    TRUE(count > 100 && classes > 1);
    OK(pldi_templates_count(templates, NULL, NULL));
    OK(pldi_templates_class_name(templates, 0, &name));
    TRUE(name.length > 0);
    OK(pldi_templates_class_name(templates, PLDI_NO_CLASS, &name));
    TRUE(name.length == 0 && name.text != NULL);
    EXPECT(PLDI_ERROR_NULL, pldi_templates_class_name(templates, 0, NULL));
}

static void frames(const uint16_t *depth, const uint8_t *rgb, const pldi_templates *templates) {
    void *memory = garbage(PLDI_WORKSPACE_SIZE), *second_memory = garbage(PLDI_WORKSPACE_SIZE);
    void *pipeline_memory = garbage(PLDI_PIPELINE_SIZE), *nothing = garbage(PLDI_WORKSPACE_SIZE);
    pldi_workspace *workspace, *second;
    pldi_pipeline *pipeline;
    pldi_params params;
    pldi_templates other = *templates;
    pldi_detection found[PLDI_MAX_DETECTIONS], again[PLDI_MAX_DETECTIONS], marked;
    pldi_hypothesis hypotheses[PLDI_MAX_HYPOTHESES];
    pldi_rejected rejected[PLDI_MAX_REJECTED];
    pldi_floor floor;
    pldi_depth_row depth_row = {PLDI_DEPTH_MM, depth, PLDI_WIDTH};
    pldi_colour_row colour_row = {PLDI_COLOUR_RGB888, rgb, PLDI_WIDTH * 3, 0, 1};
    const uint16_t *image;
    uint16_t *empty = calloc(PIXELS, sizeof *empty);
    size_t count, all, row, i;

    OK(pldi_default_params(&params));
    OK(pldi_params_for_templates(&params, templates));
    EXPECT(PLDI_ERROR_NULL, pldi_params_for_templates(NULL, templates));
    EXPECT(PLDI_ERROR_NULL, pldi_params_for_templates(&params, NULL));
    pipeline = pipeline_of(pipeline_memory, &params);
    OK(pldi_init(memory, PLDI_WORKSPACE_SIZE, &workspace));
    OK(pldi_init(second_memory, PLDI_WORKSPACE_SIZE, &second));

    /* Before a frame. */
    EXPECT(PLDI_ERROR_ORDER, pldi_push_row(pipeline, workspace, &depth_row, NULL));
    EXPECT(PLDI_ERROR_ORDER, pldi_finish_frame(pipeline, workspace, templates));
    EXPECT(PLDI_ERROR_ORDER, pldi_get_detections(workspace, templates, found, PLDI_MAX_DETECTIONS, &count));
    EXPECT(PLDI_ERROR_ORDER, pldi_get_floor(workspace, &floor));
    EXPECT(PLDI_ERROR_ORDER, pldi_get_depth(workspace, &image));

    /* A whole frame. */
#define PROCESS(p, w, t, d, dn, c, cn) pldi_process_frame(p, w, t, d, dn, c, cn)
    EXPECT(PLDI_ERROR_NULL, PROCESS(NULL, workspace, templates, depth, PIXELS, rgb, 3 * PIXELS));
    EXPECT(PLDI_ERROR_NULL, PROCESS(pipeline, NULL, templates, depth, PIXELS, rgb, 3 * PIXELS));
    EXPECT(PLDI_ERROR_NULL, PROCESS(pipeline, workspace, NULL, depth, PIXELS, rgb, 3 * PIXELS));
    EXPECT(PLDI_ERROR_NULL, PROCESS(pipeline, workspace, templates, NULL, PIXELS, rgb, 3 * PIXELS));
    EXPECT(PLDI_ERROR_LENGTH, PROCESS(pipeline, workspace, templates, depth, PIXELS - 1, rgb, 3 * PIXELS));
    EXPECT(PLDI_ERROR_LENGTH, PROCESS(pipeline, workspace, templates, depth, PIXELS, rgb, 3 * PIXELS - 1));
    EXPECT(PLDI_ERROR_LENGTH, PROCESS(pipeline, workspace, templates, depth, 0, rgb, 3 * PIXELS));
    EXPECT(PLDI_ERROR_LENGTH, PROCESS(pipeline, workspace, templates, depth, SIZE_MAX, NULL, 0));
    EXPECT(PLDI_ERROR_ALIGNMENT, PROCESS(pipeline, workspace, templates, (const uint16_t *)((const char *)depth + 1), PIXELS, NULL, 0));
    EXPECT(PLDI_ERROR_OVERLAP, PROCESS(pipeline, workspace, templates, (const uint16_t *)memory + 8, PIXELS, NULL, 0));
    EXPECT(PLDI_ERROR_OVERLAP, PROCESS(pipeline, workspace, templates, depth, PIXELS, (const uint8_t *)memory, 3 * PIXELS));
    EXPECT(PLDI_ERROR_NOT_INITIALISED, PROCESS((pldi_pipeline *)nothing, workspace, templates, depth, PIXELS, NULL, 0));
    EXPECT(PLDI_ERROR_NOT_INITIALISED, PROCESS(pipeline, (pldi_workspace *)nothing, templates, depth, PIXELS, NULL, 0));
    EXPECT(PLDI_ERROR_NOT_INITIALISED, PROCESS(pipeline, workspace, (pldi_templates *)nothing, depth, PIXELS, NULL, 0));
    EXPECT(PLDI_ERROR_ALIGNMENT, PROCESS(pipeline, (pldi_workspace *)((char *)memory + 4), templates, depth, PIXELS, NULL, 0));
    OK(PROCESS(pipeline, workspace, templates, depth, PIXELS, rgb, 3 * PIXELS));

    /* Its results. */
    OK(pldi_get_floor(workspace, &floor));
    TRUE(floor.found == 1 && floor.height > PLDI_MM(1000) && floor.height < PLDI_MM(1500) && floor.normal[1] < 0);
    OK(pldi_get_detections(workspace, templates, found, PLDI_MAX_DETECTIONS, &all));
    TRUE(all > 0);
    for (i = 0; i < all; i++)
        TRUE(found[i].best.class_name.length > 0 && found[i].best.score > 32767 && found[i].cluster.centre_mm[2] > 500);
    memset(&marked, 0x5A, sizeof marked);
    again[all - 1] = marked;
    EXPECT(PLDI_ERROR_ARRAY_SHORT, pldi_get_detections(workspace, templates, again, all - 1, &count));
    TRUE(count == all && memcmp(&again[all - 1], &marked, sizeof marked) == 0);
    EXPECT(PLDI_ERROR_ARRAY_SHORT, pldi_get_detections(workspace, templates, NULL, 0, &count));
    EXPECT(PLDI_ERROR_NULL, pldi_get_detections(workspace, templates, NULL, 1, &count));
    EXPECT(PLDI_ERROR_NULL, pldi_get_detections(workspace, templates, found, 1, NULL));
    EXPECT(PLDI_ERROR_NULL, pldi_get_detections(NULL, templates, found, 1, &count));
    EXPECT(PLDI_ERROR_NULL, pldi_get_detections(workspace, NULL, found, 1, &count));
    EXPECT(PLDI_ERROR_OVERLAP, pldi_get_detections(workspace, templates, (pldi_detection *)memory, 1, &count));
    EXPECT(PLDI_ERROR_LENGTH, pldi_get_detections(workspace, templates, found, SIZE_MAX, &count));
    OK(pldi_get_hypotheses(workspace, templates, 0, hypotheses, PLDI_MAX_HYPOTHESES, &count));
    TRUE(count > 1 && hypotheses[0].distance <= hypotheses[1].distance && hypotheses[0].score == found[0].best.score);
    OK(pldi_get_hypotheses(workspace, templates, SIZE_MAX, hypotheses, PLDI_MAX_HYPOTHESES, &count));
    TRUE(count == 0);
    OK(pldi_get_rejected(workspace, rejected, PLDI_MAX_REJECTED, &count));
    TRUE(count > 0 && rejected[0].reason <= PLDI_REJECTED_OCCLUDED);
    EXPECT(PLDI_ERROR_ARRAY_SHORT, pldi_get_rejected(workspace, rejected, 1, &count));
    EXPECT(PLDI_ERROR_NULL, pldi_get_floor(workspace, NULL));
    OK(pldi_get_depth(workspace, &image));
    for (i = 0, count = 0; i < PIXELS; i++) count += image[i] > 0;
    TRUE(count > PIXELS / 2);
    OK(pldi_get_n(workspace, &image));
    for (i = 0, count = 0; i < PIXELS; i++) count += image[i] > 0;
    TRUE(count > 100);
    EXPECT(PLDI_ERROR_NULL, pldi_get_n(workspace, NULL));
    EXPECT(PLDI_ERROR_OVERLAP, pldi_get_n(workspace, (const uint16_t **)memory));

    /* The same frame row by row, in the other workspace, with errors on the way. */
    OK(pldi_begin_frame(pipeline, second));
    EXPECT(PLDI_ERROR_NULL, pldi_push_row(pipeline, second, NULL, NULL));
    depth_row.values = NULL;
    EXPECT(PLDI_ERROR_NULL, pldi_push_row(pipeline, second, &depth_row, NULL));
    depth_row.values = (const uint16_t *)((const char *)depth + 1);
    EXPECT(PLDI_ERROR_ALIGNMENT, pldi_push_row(pipeline, second, &depth_row, NULL));
    depth_row.values = (const uint16_t *)second_memory;
    EXPECT(PLDI_ERROR_OVERLAP, pldi_push_row(pipeline, second, &depth_row, NULL));
    depth_row.values = depth;
    depth_row.count = PLDI_WIDTH - 1;
    EXPECT(PLDI_ERROR_LENGTH, pldi_push_row(pipeline, second, &depth_row, NULL));
    depth_row.count = 0;
    EXPECT(PLDI_ERROR_LENGTH, pldi_push_row(pipeline, second, &depth_row, NULL));
    depth_row.count = PLDI_WIDTH;
    depth_row.format = 7;
    EXPECT(PLDI_ERROR_FORMAT, pldi_push_row(pipeline, second, &depth_row, NULL));
    depth_row.format = PLDI_DEPTH_MM;
#define COLOUR(status, member, value) \
    do { \
        pldi_colour_row bad = colour_row; \
        bad.member = value; \
        EXPECT(status, pldi_push_row(pipeline, second, &depth_row, &bad)); \
    } while (0)
    COLOUR(PLDI_ERROR_NULL, data, NULL);
    COLOUR(PLDI_ERROR_FORMAT, format, 7);
    COLOUR(PLDI_ERROR_LENGTH, row_bytes, PLDI_WIDTH * 3 - 1);
    COLOUR(PLDI_ERROR_LENGTH, row_bytes, 0);
    COLOUR(PLDI_ERROR_LENGTH, row_bytes, SIZE_MAX);
    COLOUR(PLDI_ERROR_LENGTH, rows, 0);
    COLOUR(PLDI_ERROR_LENGTH, rows, 9);
    COLOUR(PLDI_ERROR_LENGTH, rows, 2);
    COLOUR(PLDI_ERROR_LENGTH, format, PLDI_COLOUR_YUYV);
    COLOUR(PLDI_ERROR_LENGTH, format, PLDI_COLOUR_BAYER_GRBG);
    COLOUR(PLDI_ERROR_LENGTH, format, PLDI_COLOUR_RGB565);
    COLOUR(PLDI_ERROR_OVERLAP, data, second_memory);
    for (row = 0; row < PLDI_HEIGHT; row++) {
        if (row == 100) {
            EXPECT(PLDI_ERROR_ORDER, pldi_finish_frame(pipeline, second, templates));
            EXPECT(PLDI_ERROR_ORDER, pldi_get_floor(second, &floor));
        }
        depth_row.values = depth + row * PLDI_WIDTH;
        colour_row.data = rgb + row * PLDI_WIDTH * 3;
        OK(pldi_push_row(pipeline, second, &depth_row, &colour_row));
    }
    EXPECT(PLDI_ERROR_ORDER, pldi_push_row(pipeline, second, &depth_row, &colour_row));
    memset(&other, 0, sizeof other);
    EXPECT(PLDI_ERROR_NOT_INITIALISED, pldi_finish_frame(pipeline, second, &other));
    OK(pldi_finish_frame(pipeline, second, templates));
    EXPECT(PLDI_ERROR_ORDER, pldi_finish_frame(pipeline, second, templates));
    OK(pldi_get_detections(second, templates, again, PLDI_MAX_DETECTIONS, &count));
    TRUE(count == all);
    for (i = 0; i < all; i++)
        TRUE(again[i].best.distance == found[i].best.distance && again[i].best.object == found[i].best.object &&
             memcmp(&again[i].cluster, &found[i].cluster, sizeof found[i].cluster) == 0);

    /* The pipeline of the defaults, in constant memory, does the same. */
    OK(PROCESS(pldi_default_pipeline(), second, templates, depth, PIXELS, rgb, 3 * PIXELS));
    OK(pldi_get_detections(second, templates, again, PLDI_MAX_DETECTIONS, &count));
    TRUE(count == all && again[0].best.distance == found[0].best.distance);

    /* Every format of rows, with k = 1 and 2, and raw disparity: no result to compare with, but nothing read beyond the end. */
    {
        static const uint32_t formats[] = {PLDI_COLOUR_RGB888, PLDI_COLOUR_RGB565, PLDI_COLOUR_YUYV, PLDI_COLOUR_BAYER_RGGB,
                                           PLDI_COLOUR_BAYER_GRBG, PLDI_COLOUR_BAYER_GBRG, PLDI_COLOUR_BAYER_BGGR};
        static const size_t bytes[] = {3, 2, 2, 1, 1, 1, 1};
        uint32_t k;
        for (i = 0; i < 7; i++)
            for (k = i < 3 ? 1 : 2; k <= 2; k++) {
                size_t line = bytes[i] * k * PLDI_WIDTH, stride = line + 6;
                uint8_t *colour = garbage(stride * (k - 1) + line);
                uint16_t *raw = garbage(sizeof *raw * k * PLDI_WIDTH);
                pldi_depth_row wide = {PLDI_DEPTH_RAW, raw, k * PLDI_WIDTH};
                pldi_colour_row rows = {formats[i], colour, line, stride, k};
                OK(pldi_begin_frame(pipeline, workspace));
                OK(pldi_push_row(pipeline, workspace, &wide, &rows));
                rows.stride = SIZE_MAX / 2 + 7;
                if (k == 2) EXPECT(PLDI_ERROR_LENGTH, (rows.rows = 4, pldi_push_row(pipeline, workspace, &wide, &rows)));
                free(colour);
                free(raw);
            }
        EXPECT(PLDI_ERROR_ORDER, pldi_get_n(workspace, &image));
    }

    /* A frame without anything is no error. */
    OK(PROCESS(pipeline, workspace, templates, empty, PIXELS, NULL, 0));
    OK(pldi_get_floor(workspace, &floor));
    OK(pldi_get_n(workspace, &image));
    TRUE(floor.found == 0 && image == NULL);
    OK(pldi_get_detections(workspace, templates, NULL, 0, &count));
    TRUE(count == 0);

    /* Templates of other view parameters. */
    params.view.hash ^= 1;
    pipeline = pipeline_of(pipeline_memory, &params);
    EXPECT(PLDI_ERROR_TEMPLATES_PARAMETERS, PROCESS(pipeline, workspace, templates, depth, PIXELS, NULL, 0));
    params.version = 0;
    EXPECT(PLDI_ERROR_VERSION, pldi_params_for_templates(&params, templates));
    free(memory);
    free(second_memory);
    free(pipeline_memory);
    free(nothing);
    free(empty);
}

int main(int argc, char **argv) {
    size_t size, depth_size, rgb_size;
    uint8_t *file, *depth, *rgb;
    pldi_templates templates[2];
    TRUE(argc == 2);
    file = contents(argv[1], "templates.pldt", &size);
    depth = contents(argv[1], "frame.depth", &depth_size);
    rgb = contents(argv[1], "frame.rgb", &rgb_size);
    TRUE(depth_size == 2 * PIXELS && rgb_size == 3 * PIXELS);
    versions_and_texts();
    objects();
    parameters();
    template_bytes(file, size, templates);
    frames((const uint16_t *)depth, rgb, templates);
    free(file);
    free(depth);
    free(rgb);
    printf("%u checks\n", checks);
    return 0;
}
