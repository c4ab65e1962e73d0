#pragma once

// Bits that flip in the middle of a thread's work: in registers, and in the part of the stack that
// is in use. The processor stops after each instruction of that work (trap flag of amd64); the
// handler of SIGTRAP counts them, flips the bit before the drawn one, and lets the work go on. Only
// on amd64.

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "tests/support/daemon_work.h"

namespace lss::campaign {

using testing_support::DaemonThread;
inline constexpr std::array kDaemonThreads = {DaemonThread::frame, DaemonThread::bus};
inline constexpr const char* kDaemonThreadNames[] = {"frame", "bus"};

// What a program uses of the processor: general registers, instruction pointer, flags, control of
// floating point, and the registers of floating point.
struct RegisterBits {
  std::uint64_t first = 0, count = 0;
};
RegisterBits all_registers();                         // none: they cannot be flipped here
RegisterBits register_bits(const std::string& name);  // "rip"; none: there is no such register
std::string register_of(std::uint64_t bit);

struct Hit {
  DaemonThread thread = DaemonThread::frame;
  std::uint64_t instruction = 0;  // before this one of the thread's, from now on
  bool stack = false;             // else a register
  std::uint64_t bit = 0;          // of all_registers(); of a byte of the stack
  double place = 0;               // of this byte in the stack: from 0, its top, to 1
};

// In this process: from now on the work of its threads is watched.
void expect(const Hit& hit);
// Since expect() in this process, or in its last copy.
struct Struck {
  bool happened = false;
  std::uintptr_t instruction = 0;  // its address
};
Struck struck();

// What a thread sets of the processor for all that follows: control of floating point, direction of
// copies, check of alignment.
std::uint64_t processor_modes();

// How many instructions `run` executes of each thread; counts to `most`.
using Instructions = std::array<std::uint64_t, kDaemonThreads.size()>;
Instructions count_instructions(const std::function<void()>& run, const Instructions& most);

// Ends this process unless it is called again before it has used so many seconds of CPU. Done when
// a bit is flipped.
inline constexpr unsigned kHang_s = 2;
void allow_cpu(unsigned seconds = kHang_s);

}  // namespace lss::campaign
