#pragma once

// What one cycle of a vehicle costs on this machine: the instructions of the longest of recorded
// frames, and the time of an instruction. A recording is executed again and again: to find the
// frames that take longest, to count their instructions one by one (PTRACE_SINGLESTEP, which needs
// no counter of the processor and gives the same number in each run), and to measure them with
// empty caches. Ordinary thread; processes of its own.

#include <cstdint>
#include <filesystem>
#include <tl/expected.hpp>

#include "daemon/replay/replay_files.h"

namespace lss::record {

struct CycleCost {
  std::uint64_t frames = 0;   // executed
  std::uint64_t counted = 0;  // of them those that took longest
  // The frame with the most instructions, of those counted. An iteration of a repeated string
  // instruction counts as one.
  std::uint64_t frame = 0, instructions = 0;
  // The largest of the counted frames: time of a frame, its caches emptied before, the quickest of
  // five, by its instructions.
  double ns_per_instruction = 0;
  double longest_ns = 0;  // so measured; not of the same frame by necessity
};

// `most`: so many frames are counted; a step takes some 5 us, 30 in a virtual machine. The error
// says what to do.
tl::expected<CycleCost, std::string> cycle_cost(const std::filesystem::path& path,
                                                std::size_t most);

}  // namespace lss::record
