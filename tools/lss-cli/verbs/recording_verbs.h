#pragma once

// The verbs of recordings except `log`; see verbs.h. Called once per Grammar.

#include "tools/lss-cli/verbs/grammar.h"

namespace lss::cli {

void add_record_verb(Grammar& grammar);
void add_plot_verb(Grammar& grammar);
void add_report_verb(Grammar& grammar);

}  // namespace lss::cli
