#pragma once

// The On-Board Computer's interface to Lunar Zebro during a mission: the commands of the DDS
// interface and the daemon's messages, its own power and a Sun sensor. The autopilot has no other
// input.

#include <zebro_fields.h>  // of the IDL

#include <cstdint>
#include <initializer_list>

#include "daemon/cycle/messages.h"
#include "idl/zebro/commands.h"

namespace lss::zebro::mission {

class Link {
 public:
  virtual ~Link() = default;

  // The sequence number of the command.
  virtual std::uint64_t send(std::uint16_t kind, std::initializer_list<double> parameters) = 0;
  // The newest acknowledgement of a command; nullptr: none yet.
  virtual const Ack* answer(std::uint64_t sequence) const = 0;
  virtual State state() const = 0;
  virtual Mode mode() const = 0;
  virtual const lss_ZebroTelemetry& telemetry() const = 0;

  virtual double charge() const = 0;       // of the battery, 0..1
  virtual bool daylight() const = 0;       // enough is left to go on
  virtual double heading_rad() const = 0;  // by the Sun, from the course, counter-clockwise

  virtual void pass(double seconds) = 0;  // at most; at once when the state changes
  // The OBC switches itself and the daemon off until the battery is this full; when it is back, the
  // daemon knows nothing of before.
  virtual void sleep(double charge) = 0;
  // A person inspects, repairs what is possible, and confirms that it is safe to continue.
  virtual void ask_person() = 0;
};

}  // namespace lss::zebro::mission
