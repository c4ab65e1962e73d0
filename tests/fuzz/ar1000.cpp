// The altimeter AR1000: any bytes on its line.

#include "drivers/talaris/ar1000.h"

#include "tests/fuzz/sensor_line.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss::talaris;
  Ar1000 line(Ar1000Parameters{});
  constexpr std::array<std::uint8_t, 2> kEnd = {'\r', '\n'};
  constexpr std::array<std::uint8_t, 4> kNumber = {'1', '2', '.', '5'},
                                        kError = {'E', '1', '5', '\r'};
  const std::array<std::span<const std::uint8_t>, 3> answers = {kEnd, kNumber, kError};
  listen(line, lss::fuzz::Input({data, size}), answers);
  return 0;
}
