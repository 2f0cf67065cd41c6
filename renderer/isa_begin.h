// Opens the part of a kernel that is compiled for its instruction set: x86-64-v3 as all else, or v4 where
// EQUILUX_ISA_V4 is defined. Include every other header before, so that nothing shared is compiled for v4. No
// include guard: isa_end.h closes it.
#ifdef EQUILUX_ISA_V4
#pragma GCC push_options
#pragma GCC target("avx512f,avx512cd,avx512bw,avx512dq,avx512vl")
#endif
