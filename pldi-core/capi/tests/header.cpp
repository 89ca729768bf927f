// The header in C++: everything that it declares can be used, and links by its C name.

#include <pldi.h>

static PLDI_MEMORY(memory, PLDI_PIPELINE_SIZE);

int main() {
    pldi_params params;
    pldi_pipeline *pipeline = nullptr;
    pldi_status status = pldi_default_params(&params);
    params.floor_mode = PLDI_FLOOR_POSE;
    params.pose.pitch = PLDI_DEGREES(17.5);
    if (status == PLDI_OK) status = pldi_pipeline_init(memory, sizeof memory, &params, &pipeline);
    return status == PLDI_OK && pldi_version() == PLDI_VERSION && pldi_status_text(status)[0] == 'n' ? 0 : 1;
}
