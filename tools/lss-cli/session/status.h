#pragma once

// The status of a vehicle for people and for programs. Pure functions of received samples;
// `telemetry` is a sample of the vehicle's own topic or nullptr.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "lss.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/output.h"

namespace lss::cli {

const char* state_name(lss_State state);
// none, good, one_copy, partly, lost; and the problem, or "".
const char* saved_name(lss_SavedParameters saved);
const char* saved_trouble(lss_SavedParameters saved);
const char* phase_name(lss_Phase phase);
const char* severity_name(lss_Severity severity);

// "RM: module does not answer".
std::string fault_text(const Vehicle& vehicle, const lss_Fault& fault);

// The daemon and its start: "obc-1, pid 812, since 2026-11-22 10:03:04 UTC".
std::string instance_text(const lss_Instance& instance);
nlohmann::json instance_json(const lss_Instance& instance);
// Several daemons have the name of this one; empty: it is the only one.
std::optional<Problem> name_conflict(const lss_Status& status,
                                     const std::vector<lss_Instance>& instances);

// Errors first.
std::vector<Problem> problems(const Vehicle& vehicle, const lss_Status& status,
                              const void* telemetry);

// A line each, with the advice.
std::string problem_lines(const std::vector<Problem>& list, const Style& style);

// Keys are the names of idl/lss.idl; exceptions are in docs/cli.md, "For programs".
nlohmann::json status_json(const Vehicle& vehicle, const lss_Status& status, const void* telemetry);

// One screen, problems first.
std::string status_screen(const Vehicle& vehicle, const lss_Status& status, const void* telemetry,
                          const Style& style);

// "Operational, Walking forward, high: 0.083 m ...".
std::string status_line(const Vehicle& vehicle, const lss_Status& status, const void* telemetry);

// A later report of the same series, which contains the earlier one.
bool is_newer(const lss_Event& event, const lss_Event& than);

// One event as a line.
std::string event_line(const lss_Event& event, const Style& style);
nlohmann::json event_json(const Vehicle& vehicle, const lss_Event& event);

}  // namespace lss::cli
