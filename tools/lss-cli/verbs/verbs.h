#pragma once

// The verbs of lss-cli, a file for each group. Called once per Grammar.

#include <string>

#include "tools/lss-cli/verbs/grammar.h"

namespace lss::cli {

void add_verbs(Grammar& grammar);  // all of them, in the order of --help

void add_status_verbs(Grammar& grammar);  // status, health, watch, data
void add_event_verbs(Grammar& grammar);
void add_dictionary_verbs(Grammar& grammar);  // dictionary, codes
void add_timing_verbs(Grammar& grammar);
void add_log_verbs(Grammar& grammar);  // events, timing
void add_param_verb(Grammar& grammar);
void add_command_verbs(Grammar& grammar);  // those of the command tables; heartbeat, command
void add_estop_verb(Grammar& grammar);
void add_sequence_verbs(Grammar& grammar);  // run, shell; wait within them
void add_doctor_verbs(Grammar& grammar);
void add_keystore_verb(Grammar& grammar);
void add_completion_verbs(Grammar& grammar);

std::string version_text();

}  // namespace lss::cli
