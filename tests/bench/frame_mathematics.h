#pragma once

// Row vii: the mathematics of one frame of those vehicles that are not in every build.

#include <functional>

#include "tests/bench/bench.h"

namespace lss::bench {

// The compiler must believe that somebody looks at it.
inline void keep(const void* memory) { asm volatile("" : : "r"(memory) : "memory"); }

// Each call goes through the same recorded frames and gives the ns of one.
std::function<Samples()> ardito_frame(const Options& options);

// TALARIS: one frame of navigation, 40 samples of the IMU and two ranges, ns.
std::function<Samples()> talaris_navigation(const Options& options);
// The same with both IMUs and control allocation.
std::function<Samples()> talaris_whole(const Options& options);
// Single problems of control allocation.
Figures talaris_allocation(const Options& options);
// One frame of navigation with so many samples of the IMU, of so many recorded frames.
double talaris_frame_us(int imu_samples, int frames);
// The same filter, dense.
Figure talaris_against_dense(const Options& options);

}  // namespace lss::bench
