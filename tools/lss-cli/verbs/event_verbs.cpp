// events: what happened.

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

constexpr double kHistory_s = 5;  // for the old events, on a busy machine

using Events = std::map<std::uint64_t, lss_Event>;  // by index

// All that have arrived. DDS gives those of one id and subject together.
Events take(Session& session) {
  Events events;
  while (const std::optional<lss_Event> event = session.link().next_event())
    events.insert({event->index, *event});
  return events;
}

// The old ones, of each series its newest report. They arrive in order, so with the daemon's last
// event all are there.
std::vector<lss_Event> history(Session& session, Output& output) {
  Events events;
  session.link().open_events();
  const std::uint64_t newest = session.status().events;
  const Clock::time_point until = Clock::now() + seconds(kHistory_s);
  while (newest != 0 && (events.empty() || events.rbegin()->first < newest)) {
    if (Clock::now() >= until) {
      output.note(fmt::format("event {} did not arrive within {} s", newest, kHistory_s));
      break;
    }
    session.pump(until);
    events.merge(take(session));
  }
  std::vector<lss_Event> list;
  for (const auto& [index, event] : events) {
    std::erase_if(list, [&event = event](const lss_Event& e) { return is_newer(event, e); });
    list.push_back(event);
  }
  return list;
}

ExitCode run_events(Context& context, bool follow, std::size_t last) {
  Session& session = context.session();
  std::vector<lss_Event> list = history(session, context.output);
  nlohmann::json all = nlohmann::json::array();
  const auto show = [&](const lss_Event& event) {
    const nlohmann::json json = event_json(session.vehicle(), event);
    context.output.print(event_line(event, context.output.style()));
    context.output.record(json);
    if (!context.output.stream()) all.push_back(json);
  };
  if (last > 0 && list.size() > last)
    list.erase(list.begin(), list.end() - static_cast<std::ptrdiff_t>(last));
  std::uint64_t newest = list.empty() ? 0 : list.back().index;
  std::ranges::for_each(list, show);
  try {
    while (follow) {
      session.pump(Clock::now() + seconds(1));
      for (const auto& [index, event] : take(session)) {
        if (newest != 0 && index > newest + 1)
          context.output.note(fmt::format("{} events were lost", index - newest - 1));
        newest = index;
        show(event);
      }
    }
  } catch (const Interrupted&) {
  }
  if (!context.output.stream()) context.output.document({{"events", std::move(all)}});
  return ExitCode::completed;
}

}  // namespace

void add_event_verbs(Grammar& grammar) {
  CLI::App& events =
      grammar.verb("events", "what happened: the last 16 events of each kind and part",
                   "  lss-cli events --last 20\n  lss-cli --jsonl events --follow\n");
  auto follow = std::make_shared<bool>(false);
  auto last = std::make_shared<std::size_t>(0);
  events.add_flag("-f,--follow", *follow, "go on until Ctrl-C");
  events.add_option("--last", *last, "only so many of the old ones");
  grammar.on(events,
             [follow, last](Context& context) { return run_events(context, *follow, *last); });
}

}  // namespace lss::cli
