#pragma once

// The verbs of recordings except `log`; see verbs.h. Called once per Grammar.

#include <string>

#include "tools/lss-cli/verbs/grammar.h"

namespace lss::cli {

void add_record_verb(Grammar& grammar);
void add_plot_verb(Grammar& grammar);
void add_report_verb(Grammar& grammar);

// To --out.
void write_file(const std::string& content, const std::string& out);

}  // namespace lss::cli
