#pragma once

// Protection of the program itself against bits that radiation flips: code, constants, and what the
// loader relocated and then write-protected (tables of virtual functions), against checksums made
// at start. Libraries are not looked at. One thread, not real-time.

#include <cstdint>
#include <span>
#include <vector>

#include "daemon/cycle/sum.h"

namespace lss {

class ProgramCheck {
 public:
  static constexpr std::size_t kBlock = 64 * 1024;

  ProgramCheck();  // of this program
  explicit ProgramCheck(std::vector<std::span<const std::uint8_t>> ranges);

  // Looks at the next block, some 10 us. False: it differs from before; once for each difference.
  // A debugger and probes change code, too: while a program traces this one, all is good.
  bool step();
  std::span<const std::uint8_t> last() const { return blocks_[last_].bytes; }  // of the last step
  std::size_t blocks() const { return blocks_.size(); }

 private:
  struct Block {
    std::span<const std::uint8_t> bytes;
    Sum sum;
  };
  std::vector<Block> blocks_;
  std::size_t next_ = 0, last_ = 0;
};

}  // namespace lss
