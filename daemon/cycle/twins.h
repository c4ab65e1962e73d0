#pragma once

// Protection of what the cycle remembers against single bits that radiation flips in memory: the
// vehicle with its controller, parameters and counters, and the supervisor, are held twice, and
// compared before every frame. A checksum says which of two that differ is as the last frame left
// it; that one replaces the other. When neither is, the frame gets memory_lost, and the vehicle
// stops. Nothing else writes these objects between frames, so their bytes are compared as they are,
// pointers and padding included. Frame thread; bounded, no allocation; costs one comparison, one
// copy and one sum of the objects' bytes in each frame.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "daemon/cycle/sum.h"
#include "daemon/cycle/supervisor.h"

namespace lss {

// The second copy of kSize bytes, and their sum.
template <std::size_t kSize>
class Twin {
 public:
  void seal(std::span<const std::uint8_t, kSize> live) noexcept {
    std::memcpy(copy_.data(), live.data(), kSize);
    sum_ = sum(copy_);
  }

  MemoryCheck check(std::span<std::uint8_t, kSize> live) noexcept {
    asm volatile("" ::: "memory");  // the compiler sees no writer
    if (std::memcmp(copy_.data(), live.data(), kSize) == 0) return MemoryCheck::good;
    if (sum(copy_) == sum_) {
      std::memcpy(live.data(), copy_.data(), kSize);
      return MemoryCheck::corrected;
    }
    const bool live_is_good = sum(live) == sum_;
    seal(live);
    return live_is_good ? MemoryCheck::corrected : MemoryCheck::lost;
  }

  std::span<std::uint8_t, kSize> copy() noexcept { return copy_; }       // for tests
  bool same(std::span<const std::uint8_t, kSize> live) const noexcept {  // for tests
    return std::memcmp(copy_.data(), live.data(), kSize) == 0;
  }

 private:
  alignas(64) std::array<std::uint8_t, kSize> copy_{};
  Sum sum_{};
};

// A value that waits for another thread: two copies of its bytes, and their sum.
template <class T>
class Sealed {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Sealed() noexcept : Sealed(T{}) {}
  explicit Sealed(const T& value) noexcept {
    std::memcpy(copies_[0].data(), &value, sizeof(T));
    copies_[1] = copies_[0];
    sum_ = sum(copies_[0]);
  }

  // False: neither copy is as it was sealed, and the value is not touched.
  bool open(T& value) const noexcept {
    asm volatile("" ::: "memory");  // the compiler sees no writer
    const bool same = std::memcmp(copies_[0].data(), copies_[1].data(), sizeof(T)) == 0;
    for (const auto& copy : copies_) {
      if (!same && sum(copy) != sum_) continue;
      std::memcpy(&value, copy.data(), sizeof(T));
      return true;
    }
    return false;
  }

 private:
  std::array<std::array<std::uint8_t, sizeof(T)>, 2> copies_;
  Sum sum_;
};

template <class T>
std::span<std::uint8_t, sizeof(T)> bytes_of(T& object) noexcept {
  return std::span<std::uint8_t, sizeof(T)>(reinterpret_cast<std::uint8_t*>(&object), sizeof(T));
}

// Of a vehicle and its supervisor, whose outbox only lasts for a frame.
template <class Vehicle>
class Twins {
 public:
  static constexpr std::size_t kSupervisor = sizeof(Supervisor) - sizeof(Supervisor::Outbox);

  // Before the first frame, and after each, when the others were given its output.
  void seal(Vehicle& vehicle, Supervisor& supervisor) noexcept {
    vehicle_.seal(bytes_of(vehicle));
    supervisor_.seal(bytes_of(supervisor).template first<kSupervisor>());
  }
  // Before a frame.
  MemoryCheck check(Vehicle& vehicle, Supervisor& supervisor) noexcept {
    return std::max(vehicle_.check(bytes_of(vehicle)),
                    supervisor_.check(bytes_of(supervisor).template first<kSupervisor>()));
  }
  bool same(Vehicle& vehicle, Supervisor& supervisor) const noexcept {  // for tests
    return vehicle_.same(bytes_of(vehicle)) &&
           supervisor_.same(bytes_of(supervisor).template first<kSupervisor>());
  }

 private:
  Twin<sizeof(Vehicle)> vehicle_;
  Twin<kSupervisor> supervisor_;
};

}  // namespace lss
