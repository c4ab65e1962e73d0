#pragma once

// The documents of DDS Security that the permissions CA signs (OMG DDS Security 1.1, 9.4.1): who
// may join a domain, and which topics a role writes and reads (docs/security.md). Pure functions.

#include <ctime>
#include <string>

#include "tools/lss-cli/keystore/keystore.h"

namespace lss::cli {

std::string governance_text();
// For every certificate with the subject CN=`name`, until `until_s` (UTC, seconds from 1970).
std::string permissions_text(const std::string& name, DdsRole role, std::time_t until_s);
// The role in a document of permissions_text(); "other": it is none.
std::string role_in(const std::string& permissions);

}  // namespace lss::cli
