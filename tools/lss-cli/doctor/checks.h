#pragma once

// The checks of lss-cli doctor, by subject, each a function of the machine and of the configuration
// where there is one. They query and judge; they send no command. Main thread; bounded, the longest
// is daemon_findings() with its time limit.

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "lss.h"
#include "tools/lss-cli/doctor/finding.h"
#include "tools/lss-cli/doctor/system.h"
#include "tools/lss-cli/show/options.h"

namespace lss::cli::doctor {

// kernel.cpp
Finding check_kernel(const System& system);
Finding check_throttle(const System& system);

// permissions.cpp. The highest priority that a thread of the daemon needs.
Finding check_fifo(const System& system, int priority);
Finding check_rtprio(const System& system, int priority);
Finding check_memlock(const System& system);

// cpus.cpp
Finding check_governor(const System& system);
Finding check_cpus(const System& system);
Finding check_thread_cpus(const System& system, const config::Config& config);
Finding check_isolation(const System& system, const config::Config* config);
Finding check_smt(const System& system);
Finding check_swap(const System& system);

// clocks.cpp
Finding check_clock_source(const System& system);
Finding check_clock_read(const System& system);
// `offset_before_ns`: System::utc_offset_ns() when the checks began.
Finding check_clock_steps(const System& system, std::int64_t offset_before_ns);

// ports.cpp and can.cpp
Finding check_port(const System& system, const config::Config& config, const config::Port& port);
Finding check_can(const System& system, const std::string& interface);

// network.cpp
Finding check_roudi(const System& system, const config::Config* config);
Finding check_dds_uri();
Finding check_interface(const System& system, const std::string& interface);
Finding check_buffers(const System& system);

// daemon.cpp. Waits for a daemon on the domain of the options, for at most their time limit, and
// reports its status.
Findings daemon_findings(const System& system, const Options& options);
Finding judge_contract(const lss_Status& status);
Finding judge_parameters(const lss_Status& status);
// For every daemon found on the domain.
Finding judge_names(const std::vector<lss_Status>& daemons);

// folders.cpp
Finding check_run_dir(const System& system);
Finding check_state_dir(const System& system);
Finding check_shm(const System& system, const config::Config* config);

}  // namespace lss::cli::doctor
