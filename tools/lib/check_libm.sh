#!/usr/bin/env bash
# check_libm.sh NM PROGRAM: fails when the program calls a function of libm whose last bit depends on processor and libc
# (docs/recording.md). Those that IEEE 754 defines to the bit, as sqrt, fmod, remainder and round, are no fault.
set -euo pipefail
symbols=$("$1" --dynamic --undefined-only "$2")
inexact='a?(sin|cos|tan)h?|atan2|sincos|exp(2|10|m1)?|log(2|10|1p)?|pow|cbrt|hypot|erfc?|[lt]gamma'
if grep -E "^ *U ($inexact)[fl]?(@|$)" <<< "$symbols"; then
  echo "$2 calls these of libm; gnc/math.h has such functions with the same bits everywhere"
  exit 1
fi
grep -q '@GLIBC' <<< "$symbols" || { echo "$2 names no function of libc: not read" && exit 1; }
