#include "daemon/vehicles/talaris/solver.h"

#include "idl/talaris/codes.h"

namespace lss::talaris {

FaultClass class_of(FaultId fault) noexcept {
  switch (fault) {
    case FaultId::module_silent:
    case FaultId::module_reset:
    case FaultId::node_refuses:
    case FaultId::port_lost:
    case FaultId::bus_off: return FaultClass::contact;
    default: break;
  }
  const bool navigation = fault == faults::navigation_lost || fault == faults::attitude_lost;
  return navigation ? FaultClass::navigation : FaultClass::system;
}

}  // namespace lss::talaris
