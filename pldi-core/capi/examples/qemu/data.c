/* The frame and the template file, as they lie in flash. The assembler finds the files by -I. */

__asm__(".section .rodata\n"
        ".balign 4\n"
        ".global frame_depth\nframe_depth: .incbin \"frame.depth\"\n"
        ".global frame_rgb\nframe_rgb: .incbin \"frame.rgb\"\n"
        ".global templates_begin\ntemplates_begin: .incbin \"templates.pldt\"\n"
        ".global templates_end\ntemplates_end: .byte 0\n"
        ".text\n");
