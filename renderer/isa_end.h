// Closes what isa_begin.h opened.
#ifdef EQUILUX_ISA_V4
#pragma GCC pop_options
#endif
