#pragma once

// Second-order digital filters of measured signals: Butterworth low pass for pressures (TALARIS
// thesis 4.5.2), notch for the load cell's ringing at 7 Hz (5.2.5). Bilinear transform; direct form
// II transposed.

namespace lss::gnc::talaris {

// y_k = b0 x_k + b1 x_k-1 + b2 x_k-2 - a1 y_k-1 - a2 y_k-2
struct FilterCoefficients {
  double b0 = 1, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
};

// fs: samples a second. Outside 0 < corner < fs / 2 the filter changes nothing.
FilterCoefficients butterworth(double corner_hz, double fs_hz) noexcept;

// Unit gain far from the notch, none at it; width between the -3 dB points: notch / quality. Use it
// only where fs >= 4 notch: outside 0 < notch <= fs / 4 the filter changes nothing.
FilterCoefficients notch(double notch_hz, double fs_hz, double quality) noexcept;

// Starts settled at its first sample; ignores values that are not numbers.
class Filter {
 public:
  Filter() = default;
  explicit Filter(const FilterCoefficients& coefficients) noexcept : c_(coefficients) {}

  double step(double x) noexcept;
  double value() const noexcept { return y_; }  // 0 before the first sample
  void reset() noexcept { *this = Filter(c_); }

 private:
  FilterCoefficients c_;
  double s1_ = 0, s2_ = 0;
  double y_ = 0;
  bool begun_ = false;
};

}  // namespace lss::gnc::talaris
