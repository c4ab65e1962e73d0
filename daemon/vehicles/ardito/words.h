#pragma once

// D.I.A.N.A. Ardito's names, and what clients need to drive and to show it. Pure data.

#include "daemon/cycle/text.h"

namespace lss::ardito {

const Vocabulary& vocabulary();

}  // namespace lss::ardito
