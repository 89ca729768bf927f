/* What a board needs before main, and what the C library needs of it: for QEMU's mps2 machines, with semihosting. */

#include <stddef.h>
#include <stdint.h>

extern uint32_t stack_top, data_load, data_begin, data_end, bss_begin, bss_end;
int main(void);


static int semihosting(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void leave(int code) {
    const uint32_t block[2] = {0x20026u, (uint32_t)code}; /* the application's own exit */
    semihosting(0x20, block);
    for (;;) { }
}

/* A fault is an exit code, not a machine that hangs. */
static void fault(void) {
    leave(99);
}

void reset(void) {
    uint32_t *from, *to;
    for (from = &data_load, to = &data_begin; to < &data_end;) *to++ = *from++;
    for (to = &bss_begin; to < &bss_end;) *to++ = 0;
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* CPACR: the FPU, for the hard-float calling convention */
    __asm__ volatile("dsb\nisb");
    leave(main());
}

/* The first word is the stack's end, then come the handlers: reset, NMI, hard fault, memory, bus and usage fault. */
static const struct {
    const void *stack;
    void (*handlers[15])(void);
} vectors __attribute__((section(".vectors"), used)) = {&stack_top, {reset, fault, fault, fault, fault, fault}};

/* printf comes here. There is no heap: with _sbrk refused, newlib writes without a buffer. */
int _write(int file, const char *text, int length) {
    static char line[81];
    int i = 0, n;
    (void)file;
    while (i < length) {
        for (n = 0; n < 80 && i < length;) line[n++] = text[i++];
        line[n] = 0;
        semihosting(0x04, line);
    }
    return length;
}

void *_sbrk(ptrdiff_t bytes) {
    (void)bytes;
    return (void *)-1;
}

int _close(int file) { (void)file; return -1; }
int _fstat(int file, void *status) { (void)file; (void)status; return -1; }
int _isatty(int file) { (void)file; return 1; }
int _lseek(int file, int offset, int from) { (void)file; (void)offset; (void)from; return -1; }
int _read(int file, char *text, int length) { (void)file; (void)text; (void)length; return 0; }
