#pragma once

// The states found, numbered in order, each with its predecessor, and an index by open addressing.
// 13 bytes a state and its share of the index. Any number of threads may read while none adds.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "tools/lss-lc/key.h"

namespace lss::lc {

class States {
 public:
  static constexpr unsigned kNumberBits = 24;
  static constexpr std::uint32_t kMaxNumber = (1u << kNumberBits) - 2;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  States() : slots_(1u << 12, kNone) {}

  std::uint32_t size() const { return size_; }
  Key operator[](std::uint32_t i) const { return block(i).key[i % kBlock]; }
  std::uint32_t parent(std::uint32_t i) const { return block(i).parent[i % kBlock]; }
  std::uint8_t by(std::uint32_t i) const { return block(i).by[i % kBlock]; }
  std::size_t bytes() const {
    return blocks_.size() * sizeof(Block) + blocks_.capacity() * sizeof(blocks_[0]) +
           slots_.capacity() * sizeof(slots_[0]);
  }

  // True when it is new. At most kMaxNumber.
  bool add(Key key, std::uint32_t parent, std::uint8_t by) {
    std::size_t slot = find(key);
    if (slots_[slot] != kNone) return false;
    if ((std::size_t{size_} + 1) * 4 > slots_.size() * 3) {
      grow();
      slot = find(key);
    }
    slots_[slot] = tag(key) << kNumberBits | size_;
    if (size_ % kBlock == 0) blocks_.push_back(std::make_unique_for_overwrite<Block>());
    Block& last = *blocks_.back();
    last.key[size_ % kBlock] = key;
    last.parent[size_ % kBlock] = parent;
    last.by[size_ % kBlock] = by;
    ++size_;
    return true;
  }
  // kNone: not there.
  std::uint32_t number(Key key) const {
    const std::uint32_t slot = slots_[find(key)];
    return slot == kNone ? kNone : slot & kNumber;
  }

  // The memory that a lookup of this key reads first, and second.
  void prefetch_slot(Key key) const { __builtin_prefetch(&slots_[home(key)]); }
  void prefetch_key(Key key) const {
    const std::uint32_t slot = slots_[home(key)];
    if (slot == kNone) return;
    const std::uint32_t i = slot & kNumber;
    __builtin_prefetch(&block(i).key[i % kBlock]);
  }

 private:
  static constexpr std::uint32_t kNumber = (1u << kNumberBits) - 1;
  static constexpr std::uint32_t kBlock = 4096;
  struct Block {
    std::array<Key, kBlock> key;
    std::array<std::uint32_t, kBlock> parent;
    std::array<std::uint8_t, kBlock> by;
  };

  const Block& block(std::uint32_t i) const { return *blocks_[i / kBlock]; }

  static std::uint64_t hash(Key key) { return key * 0x9E3779B97F4A7C15u; }
  std::size_t home(Key key) const { return (hash(key) >> 32) * slots_.size() >> 32; }
  static std::uint32_t tag(Key key) { return static_cast<std::uint32_t>(hash(key) >> 24) & 0xFF; }
  // Its slot, or the empty one where it belongs. A slot has the number of its state and eight bits
  // of its hash: most wrong slots are skipped without a read of the state, which is far away in
  // memory.
  std::size_t find(Key key) const {
    const std::uint32_t wanted = tag(key);
    std::size_t slot = home(key);
    for (;; slot = slot + 1 == slots_.size() ? 0 : slot + 1) {
      const std::uint32_t found = slots_[slot];
      if (found == kNone) return slot;
      if (found >> kNumberBits == wanted && (*this)[found & kNumber] == key) return slot;
    }
  }
  void grow() {
    slots_.assign(slots_.size() / 2 * 3, kNone);  // no doubling: a state has at most 8 bytes of it
    for (std::uint32_t i = 0; i < size_; ++i)
      slots_[find((*this)[i])] = tag((*this)[i]) << kNumberBits | i;
  }

  std::uint32_t size_ = 0;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::vector<std::uint32_t> slots_;
};

}  // namespace lss::lc
