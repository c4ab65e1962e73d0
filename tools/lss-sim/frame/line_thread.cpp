#include "tools/lss-sim/frame/line_thread.h"

#include <fmt/format.h>

#include "drivers/lockstep/lockstep.h"

namespace lss::sim {

LineThread::LineThread(std::filesystem::path link, const Uart::Parameters& parameters,
                       LineDevice& device)
    : device_(device), port_(std::move(link)), uart_(parameters, device) {}

std::string LineThread::place() const {
  return fmt::format("port {} at {} -> {}", port_.link().filename().string(), port_.link().string(),
                     port_.terminal());
}

tl::expected<void, std::string> LineThread::open() {
  if (auto opened = port_.open(); !opened) return opened;
  wire_.open(port_.link().filename().string());
  return {};
}

void LineThread::set_fault(const Fault& fault, bool attach) {
  const std::lock_guard lock(mutex_);
  uart_.faults.set(fault, attach);
}

void LineThread::close(TimeNs) {
  port_.close();
  wire_.close();
  uart_.forget();
}

TimeNs LineThread::exchange(TimeNs now) {
  read(now);
  uart_.advance(now);
  if (const auto bytes = uart_.take(now); !bytes.empty()) {
    if (!lockstep::on()) {
      port_.write(bytes);
    } else if (wire_.is_heard()) {
      wire_.sent(port_.write(bytes));
    }
  }
  return uart_.next_wake();
}

void LineThread::read(TimeNs now) {
  bool more = !lockstep::on() || wire_.coming();
  while (more) {
    const auto bytes = port_.read();
    if (!bytes.empty()) uart_.from_master(bytes, now);
    wire_.took(bytes.size());
    more = wire_.awaits(port_.fd());
  }
}

}  // namespace lss::sim
