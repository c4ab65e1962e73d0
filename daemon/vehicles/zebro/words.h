#pragma once

// Lunar Zebro's names, and what clients need to drive and to show it. Pure data.

#include "daemon/cycle/text.h"

namespace lss::zebro {

const Vocabulary& vocabulary();

}  // namespace lss::zebro
