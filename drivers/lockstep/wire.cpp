#include "drivers/lockstep/wire.h"

#include <poll.h>

#include <cstring>

#include "drivers/lockstep/page.h"

namespace lss::lockstep {
namespace {

constexpr TimeNs kLost = 5 * kSecond;  // of wall time: what did not come by then was dropped
constexpr int kLookMs = 20;

Line* find(std::string_view name) noexcept {
  for (Line& line : shared->lines) {
    if (name == line.name) return &line;
  }
  return nullptr;
}

// With the lock; nullptr: no room.
Line* take(std::string_view name) noexcept {
  if (name.empty() || name.size() >= sizeof(Line::name)) return nullptr;
  if (Line* line = find(name)) return line;
  for (Line& line : shared->lines) {
    if (line.name[0] != '\0') continue;
    std::memcpy(line.name, name.data(), name.size());
    return &line;
  }
  return nullptr;
}

void lose_all(Line& line) noexcept {
  for (std::size_t side = 0; side < kSides; ++side) line.taken[side] = line.sent[side].load();
}

}  // namespace

void close_line(Line& line, int side) noexcept {
  const auto own = static_cast<std::size_t>(side);
  line.process[own] = kNobody;
  line.reader[own] = kNobody;
  lose_all(line);
  const int reader = line.reader[1 - own].load();
  if (reader != kNobody) shared->seats[static_cast<std::size_t>(reader)].woken = true;
}

void Wire::open(std::string_view name) noexcept {
  close();
  if (!on()) return;
  const Lock lock;
  Line* line = take(name);
  if (line == nullptr) return;
  lose_all(*line);
  line->process[own_] = own_process;
  line->reader[own_] = own_seat;
  line->openings[own_].fetch_add(1);
  line_ = line;
}

void Wire::close() noexcept {
  if (!is_open()) return;
  Line& line = *line_.exchange(nullptr);
  if (gone()) return;
  const Lock lock;
  if (line.process[own_].load() == own_process) close_line(line, static_cast<int>(own_));
}

void Wire::count_sent(std::size_t count) noexcept {
  Line* const line = this->line();
  if (line == nullptr || line->process[other_].load() == kNobody) return;
  line->sent[other_].fetch_add(count);
  wake_seat(line->reader[other_].load());
}

void Wire::count_taken(std::size_t count) noexcept { line()->taken[own_].fetch_add(count); }

bool Wire::coming() noexcept {
  Line* const line = this->line();
  if (line == nullptr) return false;
  line->reader[own_] = own_seat;
  return line->sent[own_].load() > line->taken[own_].load() || !is_heard();
}

bool Wire::is_heard() const noexcept {
  return is_open() && line()->process[other_].load() != kNobody;
}

std::uint32_t Wire::openings() const noexcept {
  return is_open() ? line()->openings[other_].load() : 0;
}

bool Wire::await_more(int fd) noexcept {
  Line& line = *this->line();
  const TimeNs limit = wall_now() + kLost;
  while (line.sent[own_].load() > line.taken[own_].load()) {
    pollfd file{fd, POLLIN, 0};
    if (::poll(&file, 1, kLookMs) > 0) return true;
    if (wall_now() > limit || gone()) {
      line.taken[own_] = line.sent[own_].load();
      return false;
    }
  }
  return false;
}

std::string_view line_name(std::string_view path) noexcept {
  if (path.find("://") != path.npos) return path.substr(0, path.find('?'));
  return path.substr(path.rfind('/') + 1);
}

bool has_line(std::string_view name) noexcept {
  const Lock lock;
  const Line* line = find(name);
  return line != nullptr && line->process[1].load() != kNobody;
}

}  // namespace lss::lockstep
