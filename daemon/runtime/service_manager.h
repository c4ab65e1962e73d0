#pragma once

// What the daemon says to the service manager that started it.

#include <string_view>

namespace lss {

// Sends the service manager what sd_notify(3) describes ("WATCHDOG=1"), without waiting: one that
// stands still keeps nothing from going on. False: nobody supervises, or it does not read.
bool tell_service_manager(std::string_view state) noexcept;

}  // namespace lss
