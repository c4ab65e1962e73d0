#include "tools/lss-sim/frame/can_thread.h"

namespace lss::sim {

CanThread::CanThread(std::string name, std::string address, const CanBus::Parameters& parameters,
                     CanDevice& device)
    : name_(std::move(name)), device_(device), end_(std::move(address)), bus_(parameters, device) {}

void CanThread::set_fault(const Fault& fault, bool attach) {
  {
    const std::lock_guard lock(mutex_);
    if (!bus_.faults.set(fault, attach)) {
      const double seconds = attach ? fault.values.front() : 0;
      bus_.bus_off(monotonic_now(), static_cast<TimeNs>(seconds * kSecond));
    }
  }
  wake();
}

bool CanThread::is_off() {
  const std::lock_guard lock(mutex_);
  return bus_.is_off();
}

void CanThread::close(TimeNs now) {
  end_.close();
  bus_.advance(now);  // nodes continue and receive nothing
  bus_.forget();
}

TimeNs CanThread::exchange(TimeNs now) {
  for (const CanFrame& frame : end_.read()) bus_.from_master(frame, now);
  bus_.advance(now);
  if (const auto frames = bus_.take(now); !frames.empty()) end_.write(frames);
  return bus_.next_wake();
}

}  // namespace lss::sim
