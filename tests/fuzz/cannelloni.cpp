// CAN frames in datagrams: what is read is a possible frame, and can be written and read again.

#include "drivers/can/cannelloni.h"

#include <vector>

#include "tests/fuzz/fuzz.h"

namespace lss {
namespace {

using fuzz::must;

std::vector<CanFrame> read(CannelloniReader& reader, std::span<const std::uint8_t> datagram) {
  std::vector<CanFrame> frames;
  reader.begin(datagram);
  for (CanFrame frame; reader.next(frame);) {
    must(frame.size <= frame.data.size(), "a frame has at most eight bytes");
    must(frame.error || frame.id <= (frame.extended ? kExtendedIds : kStandardIds),
         "an identifier has 11 bits, or 29");
    frames.push_back(frame);
    must(frames.size() * 5 <= datagram.size(), "each frame has its bytes in the datagram");
  }
  return frames;
}

}  // namespace
}  // namespace lss

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lss;
  CannelloniReader reader, again;
  std::vector<CanFrame> frames = read(reader, {data, size});
  fuzz::must(reader.counters().frames == frames.size(), "frames are counted");
  CannelloniWriter writer;
  std::vector<CanFrame> written, came;
  const auto take = [&] {
    for (const CanFrame& frame : read(again, writer.take())) came.push_back(frame);
  };
  for (const CanFrame& frame : frames) {
    if (frame.error) continue;  // never sent
    if (!writer.add(frame)) {
      take();
      fuzz::must(writer.add(frame), "an empty datagram has room for a frame");
    }
    written.push_back(frame);
  }
  if (!writer.empty()) take();
  fuzz::must(written == came, "frames that were read can be written and read");
  fuzz::must(again.counters().broken() == 0, "... without any error");
  return 0;
}
