// Hides instruction sets from the programs that it is preloaded into, so that one machine stands for an older one: drivers
// that compile shaders for the processor they find, and libraries that choose their routines by it, then find less.
//
// The kernel makes `cpuid` fault (arch_prctl(2), ARCH_SET_CPUID), and the handler below answers in its place. Linux on x86-64,
// on processors that can fault (`cpuid_fault` in /proc/cpuinfo). Built and preloaded by tests/processor/older.
#define _GNU_SOURCE
#include <asm/prctl.h>
#include <cpuid.h>
#include <dlfcn.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

typedef int (*sigaction_t)(int, const struct sigaction *, struct sigaction *);

// What the program wants done with segmentation faults that are not ours.
static struct sigaction theirs;

static int real_sigaction(int number, const struct sigaction *action, struct sigaction *old) {
    static sigaction_t real;
    if (real == NULL) {
        real = (sigaction_t)dlsym(RTLD_NEXT, "sigaction");
    }
    return real(number, action, old);
}

static void set_cpuid(int allowed) {
    if (syscall(SYS_arch_prctl, ARCH_SET_CPUID, allowed) != 0) {
        static const char words[] = "this processor cannot make cpuid fault\n";
        (void)!write(STDERR_FILENO, words, sizeof words - 1);
        _exit(70);
    }
}

// Leaves what every x86-64 processor has had since 2008: SSE4.2 and POPCNT.
static void mask(uint32_t leaf, uint32_t subleaf, uint32_t r[4]) {
    if (leaf == 1) {
        r[2] &= ~(bit_FMA | bit_AVX | bit_F16C | bit_OSXSAVE | bit_XSAVE | bit_MOVBE | bit_AES);
    } else if (leaf == 7 && subleaf == 0) {
        r[1] = r[2] = r[3] = 0;
        r[0] = 0;
    } else if (leaf == 7 || leaf == 0xd || leaf == 0x14 || leaf == 0x19 || leaf == 0x24) {
        r[0] = r[1] = r[2] = r[3] = 0;
    } else if (leaf == 0x80000001) {
        r[2] &= ~(bit_ABM | bit_XOP | bit_FMA4 | bit_TBM);
    }
}

static void answer(int number, siginfo_t *info, void *context) {
    (void)number;
    greg_t *registers = ((ucontext_t *)context)->uc_mcontext.gregs;
    const uint8_t *code = (const uint8_t *)registers[REG_RIP];
    // A general protection fault has no address, so it comes as SI_KERNEL; `code` is then what was being executed.
    if (info->si_code == SI_KERNEL && code[0] == 0x0f && code[1] == 0xa2) {
        uint32_t leaf = registers[REG_RAX], subleaf = registers[REG_RCX], r[4];
        set_cpuid(1);
        __cpuid_count(leaf, subleaf, r[0], r[1], r[2], r[3]);
        set_cpuid(0);
        mask(leaf, subleaf, r);
        registers[REG_RAX] = r[0];
        registers[REG_RBX] = r[1];
        registers[REG_RCX] = r[2];
        registers[REG_RDX] = r[3];
        registers[REG_RIP] += 2;
        return;
    }
    // Any other fault is the program's own. Returning meets it again.
    real_sigaction(SIGSEGV, &theirs, NULL);
}

// A program may install a handler of its own, as an X server does. It is noted, and ours stays.
int sigaction(int number, const struct sigaction *action, struct sigaction *old) {
    if (number != SIGSEGV) {
        return real_sigaction(number, action, old);
    }
    struct sigaction was = theirs;
    if (action != NULL) {
        theirs = *action;
    }
    if (old != NULL) {
        *old = was;
    }
    return 0;
}

sighandler_t signal(int number, sighandler_t handler) {
    struct sigaction action = {.sa_handler = handler, .sa_flags = SA_RESTART}, old;
    return sigaction(number, &action, &old) == 0 ? old.sa_handler : SIG_ERR;
}

__attribute__((constructor)) static void begin(void) {
    struct sigaction action = {.sa_sigaction = answer, .sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK};
    real_sigaction(SIGSEGV, &action, &theirs);
    set_cpuid(0);
}
