#pragma once

// lss-sim, lssd and lss-cli in simulated time, as fast as this machine goes.

#include <filesystem>
#include <string>

namespace lss::bench {

struct Moving {
  const char* vehicle;
  const char* begin;
  const char* motion;
};
inline constexpr Moving kWalk{"zebro", "start; stand", "walk forward --speed high"};
inline constexpr Moving kDrive{"ardito", "start", "drive 0.3"};

// The three programs once. Returns the time that they take for so many simulated seconds of motion,
// ms. With `recording`: the daemon's flight recording as one file there.
double lockstep_ms(const Moving& moving, const std::string& plant, int seconds,
                   const std::filesystem::path& recording = {});

}  // namespace lss::bench
