#!/bin/sh
# isa_check.sh PROGRAM: instructions of AVX-512 stand in the kernels for v4 alone, so that the program runs on
# processors without them.
set -eu
objdump -d --no-show-raw-insn -C "$1" | awk '
  /^[0-9a-f]+ <.*>:$/ { name = $0; kernel = name ~ /equilux::v4::/ }
  /%zmm|%[xyz]mm(1[6-9]|2[0-9]|3[01])|\{%k[1-7]\}/ { if (kernel) ++inside; else { ++outside; print name ": " $0 } }
  END {
    printf "AVX-512: %d instructions in the kernels for v4, %d elsewhere\n", inside, outside
    exit !(inside > 1000 && outside == 0)
  }'
