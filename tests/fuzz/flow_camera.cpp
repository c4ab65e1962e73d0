// The camera: any bytes on its line.

#include "drivers/talaris/flow_camera.h"

#include "tests/fuzz/sensor_line.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss::talaris;
  FlowCamera line(FlowCameraParameters{});
  constexpr std::array<std::uint8_t, 18> kFrame = {0x24, 0x58, 0x3C, 0x00, 0x02, 0x1F,
                                                   0x09, 0x00, 0xC8, 0xDC, 0x05, 0x00,
                                                   0x00, 0x06, 0xFF, 0xFF, 0xFF, 0x35};
  const std::span<const std::uint8_t> frame(kFrame);
  const std::array<std::span<const std::uint8_t>, 4> answers = {frame, frame.first(8),
                                                                frame.subspan(8), frame.first(3)};
  listen(line, lss::fuzz::Input({data, size}), answers);
  return 0;
}
