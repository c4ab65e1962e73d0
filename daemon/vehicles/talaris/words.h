#pragma once

// TALARIS' names, and what clients need to drive and to show it. Pure data.

#include "daemon/cycle/text.h"

namespace lss::talaris {

const Vocabulary& vocabulary();

}  // namespace lss::talaris
