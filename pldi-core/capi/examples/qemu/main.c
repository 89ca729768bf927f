/* One frame through pldi, row by row as a sensor gives it, and what stands in it. Runs on a host as well as on a board. */

#include <pldi.h>
#include <stdio.h>

/* From the sensor and from flash: data.c has them here. */
extern const uint16_t frame_depth[PLDI_HEIGHT][PLDI_WIDTH];
extern const uint8_t frame_rgb[PLDI_HEIGHT][PLDI_WIDTH * 3];
extern const uint8_t templates_begin[], templates_end[];

static PLDI_MEMORY(workspace_memory, PLDI_WORKSPACE_SIZE);
static PLDI_MEMORY(pipeline_memory, PLDI_PIPELINE_SIZE);

static pldi_detection detections[PLDI_MAX_DETECTIONS];
static pldi_rejected rejected[16];

static int failed(const char *call, pldi_status status) {
    if (status != PLDI_OK) printf("%s: %s\n", call, pldi_status_text(status));
    return status != PLDI_OK;
}

#define TRY(call) do { if (failed(#call, call)) return 1; } while (0)

int main(void) {
    pldi_templates templates;
    pldi_params params;
    pldi_pipeline *pipeline;
    pldi_workspace *workspace;
    pldi_floor floor;
    size_t count, i, row;

    if (pldi_version() != PLDI_VERSION) return 1;
    TRY(pldi_templates_open(&templates, templates_begin, (size_t)(templates_end - templates_begin)));
    TRY(pldi_templates_count(&templates, &count, NULL));
    printf("pldi %d.%d.%d, %u templates\n", PLDI_VERSION_MAJOR, PLDI_VERSION_MINOR, PLDI_VERSION_PATCH, (unsigned)count);

    TRY(pldi_default_params(&params));
    params.intrinsics.fx = params.intrinsics.fy = PLDI_PIXELS(262.5); /* the sensor's, at 320x240 */
    TRY(pldi_pipeline_init(pipeline_memory, sizeof pipeline_memory, &params, &pipeline));
    TRY(pldi_init(workspace_memory, sizeof workspace_memory, &workspace));

    TRY(pldi_begin_frame(pipeline, workspace));
    for (row = 0; row < PLDI_HEIGHT; row++) {
        pldi_depth_row depth = {PLDI_DEPTH_MM, frame_depth[row], PLDI_WIDTH};
        pldi_colour_row colour = {PLDI_COLOUR_RGB888, frame_rgb[row], sizeof frame_rgb[row], 0, 1};
        TRY(pldi_push_row(pipeline, workspace, &depth, &colour));
    }
    TRY(pldi_finish_frame(pipeline, workspace, &templates));

    TRY(pldi_get_floor(workspace, &floor));
    printf("floor: %d mm below the camera\n", (int)((floor.height + 64) >> 7));
    TRY(pldi_get_detections(workspace, &templates, detections, PLDI_MAX_DETECTIONS, &count));
    for (i = 0; i < count; i++) {
        const pldi_hypothesis *best = &detections[i].best;
        const pldi_cluster *c = &detections[i].cluster;
        printf("%.*s (%.*s): score %u/65536, distance %u/65536, at %d %d %d mm, pixels %d %d %d %d\n",
               (int)best->class_name.length, best->class_name.text, (int)best->object_name.length, best->object_name.text,
               (unsigned)best->score, (unsigned)best->distance, (int)c->centre_mm[0], (int)c->centre_mm[1],
               (int)c->centre_mm[2], c->bbox[0], c->bbox[1], c->bbox[2], c->bbox[3]);
    }
    TRY(pldi_get_rejected(workspace, rejected, sizeof rejected / sizeof *rejected, &count));
    for (i = 0; i < count; i++)
        printf("rejected, %s: %u pixels\n", pldi_rejection_text(rejected[i].reason), (unsigned)rejected[i].cluster.pixels);
    return 0;
}
