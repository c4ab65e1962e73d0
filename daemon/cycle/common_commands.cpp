#include "daemon/cycle/common_commands.h"

namespace lss {

lc::Event common_event(const Request& r) noexcept {
  switch (static_cast<CommandKind>(r.kind)) {
    case CommandKind::emergency_stop: return lc::Event::emergency_stop;
    case CommandKind::solve: return lc::Event::solve;
    case CommandKind::reset:
      return arguments<Reset>(r).module < 0 ? lc::Event::reset_controller : lc::Event::reset_module;
    case CommandKind::request_data: return lc::Event::request_data;
    case CommandKind::reset_timing: return lc::Event::reset_timing;
    case CommandKind::restore: return lc::Event::restore;
    default: return lc::Event::none;
  }
}

lc::Event event_of(const lc::Table& table, const Request& request) noexcept {
  for (const lc::EventInfo& info : table.events) {
    if (info.kind != 0 && info.kind == request.kind) return info.event;
  }
  return common_event(request);
}

bool done_at_once(std::uint16_t kind) noexcept {
  switch (static_cast<CommandKind>(kind)) {
    case CommandKind::emergency_stop:
    case CommandKind::request_data:
    case CommandKind::reset_timing:
    case CommandKind::restore:
    case CommandKind::set_parameter:
    case CommandKind::save_parameters: return true;
    default: return false;
  }
}

bool is_beside(std::uint16_t kind) noexcept {
  switch (static_cast<CommandKind>(kind)) {
    case CommandKind::reset:
    case CommandKind::set_parameter:
    case CommandKind::save_parameters: return true;
    default: return false;
  }
}

bool is_of_parameters(std::uint16_t kind) noexcept {
  return kind == static_cast<std::uint16_t>(CommandKind::set_parameter) ||
         kind == static_cast<std::uint16_t>(CommandKind::save_parameters);
}

const CommandInfo* find_command(std::span<const CommandInfo> own, std::uint16_t kind) noexcept {
  for (const auto table : {own, std::span<const CommandInfo>(kCommonCommands)}) {
    for (const CommandInfo& info : table) {
      if (info.kind == kind) return &info;
    }
  }
  return nullptr;
}

}  // namespace lss
