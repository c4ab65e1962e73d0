// The IMU Crossbow: any bytes on its line.

#include "drivers/talaris/crossbow.h"

#include <vector>

#include "tests/fuzz/sensor_line.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss::talaris;
  lss::fuzz::Input in({data, size});
  Crossbow line(CrossbowParameters{});
  std::array<std::uint8_t, Crossbow::kPacket> packet{};
  std::uint8_t sum = 0;
  packet[0] = 0xFF;
  for (std::size_t k = 1; k + 1 < packet.size(); ++k) {
    packet[k] = in.byte();
    sum = static_cast<std::uint8_t>(sum + packet[k]);
  }
  packet.back() = sum;
  // As a terminal writes it: a good FF is two of them.
  std::vector<std::uint8_t> marked;
  for (const std::uint8_t byte : packet) marked.insert(marked.end(), byte == 0xFF ? 2 : 1, byte);
  constexpr std::array<std::uint8_t, 1> kPinged = {'H'}, kScaled = {'C'};
  const std::array<std::span<const std::uint8_t>, 3> answers = {marked, kPinged, kScaled};
  listen(line, in, answers);
  return 0;
}
