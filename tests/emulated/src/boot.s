# From the reset of the CPU to `main`: protected mode, the program to RAM, long mode, the wide registers.
# The section is the last 4 KiB of the ROM.

.section .boot, "ax"
.globl boot
boot:
descriptors:
    .quad 0
    # Flat: code of 32 bits, data, code of 64 bits.
    .quad 0x00cf9b000000ffff
    .quad 0x00cf93000000ffff
    .quad 0x00af9b000000ffff
# At 0x20.
descriptors_pointer:
    .word 31
    .long descriptors

.code16
from_reset:
    cli
    # The segment's base is 0xffff0000, and the section begins at 0xfffff000.
    # The prefix: all 32 bits of the base.
    .byte 0x66
    lgdt cs:[0xf020]
    mov eax, cr0
    or al, 1
    mov cr0, eax
    .byte 0x66, 0xea
    .long protected
    .word 8

.code32
protected:
    mov ax, 16
    mov ds, ax
    mov es, ax
    mov ss, ax
    cld

    # Page tables at 4 KiB: the first 4 GiB, in pages of 2 MiB, where they are.
    mov edi, 0x1000
    xor eax, eax
    mov ecx, 0x1800
    rep stosd
    mov dword ptr [0x1000], 0x2003
    mov dword ptr [0x2000], 0x3003
    mov dword ptr [0x2008], 0x4003
    mov dword ptr [0x2010], 0x5003
    mov dword ptr [0x2018], 0x6003
    mov edi, 0x3000
    mov eax, 0x83
    mov ecx, 2048
next_page:
    mov [edi], eax
    add edi, 8
    add eax, 0x200000
    dec ecx
    jnz next_page
    mov eax, 0x1000
    mov cr3, eax

    # PAE, OSFXSR, OSXMMEXCPT, and OSXSAVE where the CPU has XSAVE: bit 26 of what it says of itself is bit 18 here.
    mov eax, 1
    cpuid
    mov ebx, ecx
    shr ebx, 8
    and ebx, 0x40000
    mov eax, cr4
    or eax, 0x620
    or eax, ebx
    mov cr4, eax
    # LME of EFER.
    mov ecx, 0xc0000080
    rdmsr
    or eax, 0x100
    wrmsr
    # Paging and a coprocessor; no emulation of one, caches on.
    mov eax, cr0
    and eax, 0x9ffffffb
    or eax, 0x80000002
    mov cr0, eax
    .byte 0xea
    .long long
    .word 24

.code64
long:
    # The registers that the operating system keeps.
    test ebx, ebx
    jz no_wide_registers
    # Of those that this CPU has.
    mov eax, 13
    xor ecx, ecx
    cpuid
    and eax, [rip + registers]
    xor ecx, ecx
    xor edx, edx
    xsetbv
no_wide_registers:

    mov esi, offset rom
    mov edi, offset program
    mov ecx, offset program_quads
    rep movsq
    mov edi, offset bss
    mov ecx, offset bss_quads
    xor eax, eax
    rep stosq
    # The end of the RAM.
    mov esp, 0x4000000
    mov eax, offset main
    call rax

# Here the CPU starts.
.org 0xff0
.code16
    jmp from_reset
.org 0xff8
# What tests/emulated/run.sh changes: XCR0, whose bits here are x87, SSE and AVX, and whether the program only tells its
# levels.
registers:
    .long 0x7
.globl levels_only
levels_only:
    .long 0
.code64
