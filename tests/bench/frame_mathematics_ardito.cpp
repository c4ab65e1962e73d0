// Row vii, D.I.A.N.A. Ardito: the mobility controller in three instances with their vote, and the
// failure detection, while it drives over changing ground, with noise and turns.

#include "daemon/runtime/clock.h"
#include "tests/ardito/gnc/rover.h"
#include "tests/bench/frame_mathematics.h"

namespace lss::bench {
namespace {

using namespace gnc::ardito;

class Drive {
 public:
  explicit Drive(int frames) {
    test::Rover rover(7);
    rover.request.run = true;
    rover.request.speed = 0.8;
    if (!rover.settle()) throw std::runtime_error("the rover does not drive");
    begin_ = rover.redundant();
    for (int i = 0; i < frames; ++i) {
      // Slowly to one side and to the other: a faster change stops and steers.
      rover.request.sigma_rad = 0.05 * std::sin(i * 0.01);
      rover.step();
      recorded_.push_back({rover.request, rover.measured});
    }
    if (rover.command.mode != Mode::running) throw std::runtime_error("the rover stopped");
  }

  // Again the same frames, and nothing but the mathematics.
  Samples frame_ns() const {
    Redundant redundant = begin_;
    const TimeNs begin = now_ns();
    for (const Frame& frame : recorded_) {
      const Command command = redundant.step(frame.request, frame.measured);
      keep(&command);
    }
    if (redundant.report().upsets != 0) throw std::runtime_error("the instances disagree");
    return {static_cast<double>(now_ns() - begin) / static_cast<double>(recorded_.size())};
  }

 private:
  struct Frame {
    Request request;
    Measured measured;
  };
  Redundant begin_;
  std::vector<Frame> recorded_;
};

}  // namespace

std::function<Samples()> ardito_frame(const Options& options) {
  return [drive = Drive(options.count(4'000, 400))] { return drive.frame_ns(); };
}

}  // namespace lss::bench
