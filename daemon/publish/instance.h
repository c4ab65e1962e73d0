#pragma once

// Identifies this start of this daemon (lss::Instance in idl/lss.idl). Start-up, main thread.

#include "lss.h"

namespace lss::dds {

lss_Instance this_instance();

bool is_same(const lss_Instance& a, const lss_Instance& b) noexcept;

}  // namespace lss::dds
