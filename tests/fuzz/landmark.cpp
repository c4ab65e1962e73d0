// The IMU LandMark 30: any bytes on its line.

#include "drivers/talaris/landmark30.h"
#include "tests/fuzz/sensor_line.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss::talaris;
  lss::fuzz::Input in({data, size});
  LandMark30Parameters parameters;
  parameters.configure = in.below(2) == 0;
  LandMark30 line(parameters);
  // A good packet, and the next one.
  std::array<std::array<std::uint8_t, LandMark30::kPacket>, 2> packets{};
  for (std::size_t i = 0; i < packets.size(); ++i) {
    std::uint8_t sum = 0;
    packets[i][0] = 0x2A;
    packets[i][1] = static_cast<std::uint8_t>(i);
    for (std::size_t k = 2; k + 1 < packets[i].size(); ++k) packets[i][k] = in.byte();
    for (const std::uint8_t byte : packets[i]) sum = static_cast<std::uint8_t>(sum + byte);
    packets[i].back() = static_cast<std::uint8_t>(-sum);
  }
  const std::array<std::span<const std::uint8_t>, 2> answers = {packets[0], packets[1]};
  listen(line, in, answers);
  return 0;
}
