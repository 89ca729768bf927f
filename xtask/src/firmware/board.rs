//! The boards, as `tests/firmware` and QEMU call them.

/// A board of `tests/firmware`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Board {
    /// The feature that chooses it.
    pub(crate) name: &'static str,
    /// As it is called in tables.
    pub(crate) title: &'static str,
    pub(crate) target: &'static str,
    /// What code is made for; empty for what the target says.
    pub(crate) cpu: &'static str,
    /// QEMU's program and the options that choose the machine.
    pub(crate) qemu: &'static str,
    /// Whether it can compute in floats.
    pub(crate) fpu: bool,
}

pub(crate) const BOARDS: [Board; 5] = [
    Board {
        name: "an500",
        title: "Cortex-M7",
        target: "thumbv7em-none-eabihf",
        cpu: "cortex-m7",
        qemu: "qemu-system-arm -machine mps2-an500 -cpu cortex-m7",
        fpu: true,
    },
    Board {
        name: "an386",
        title: "Cortex-M4F",
        target: "thumbv7em-none-eabihf",
        cpu: "cortex-m4",
        qemu: "qemu-system-arm -machine mps2-an386 -cpu cortex-m4",
        fpu: true,
    },
    Board {
        name: "an505",
        title: "Cortex-M33",
        target: "thumbv8m.main-none-eabihf",
        cpu: "cortex-m33",
        qemu: "qemu-system-arm -machine mps2-an505 -cpu cortex-m33",
        fpu: true,
    },
    Board {
        name: "an385",
        title: "Cortex-M3",
        target: "thumbv7m-none-eabi",
        cpu: "cortex-m3",
        qemu: "qemu-system-arm -machine mps2-an385 -cpu cortex-m3",
        fpu: false,
    },
    Board {
        name: "virt",
        title: "RISC-V rv32imac",
        target: "riscv32imac-unknown-none-elf",
        cpu: "",
        qemu: "qemu-system-riscv32 -machine virt -bios none",
        fpu: false,
    },
];

/// What code for a target is made for, where a board says so.
pub(crate) fn cpu(target: &str) -> Option<&'static str> {
    BOARDS.iter().find(|board| board.target == target).map(|board| board.cpu).filter(|cpu| !cpu.is_empty())
}

impl Board {
    /// The one that firm limits are set for.
    pub(crate) const CORTEX_M7: Self = BOARDS[0];

    /// The board of that name.
    pub(crate) fn of(name: &str) -> Option<Self> {
        BOARDS.into_iter().find(|board| board.name == name)
    }
}
