#include "tools/lss-cli/verbs/shell.h"

#include <fmt/format.h>
#include <histedit.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cwchar>
#include <exception>
#include <functional>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/verbs/steps.h"

namespace lss::cli {
namespace {

constexpr int kHistoryLines = 500;

std::string history_file() {
  const char* home = std::getenv("HOME");
  return home == nullptr ? "" : std::string(home) + "/.lss-cli_history";
}

std::vector<std::string> words_before(const LineInfo& line) {
  std::vector<std::string> words{""};
  for (const char* c = line.buffer; c < line.cursor; ++c) {
    if (*c == ';') {
      words = {""};
    } else if (*c != ' ') {
      words.back().push_back(*c);
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  return words;
}

std::string common_beginning(const std::vector<std::string>& words) {
  std::string beginning = words.front();
  for (const std::string& word : words) {
    while (!word.starts_with(beginning)) beginning.pop_back();
  }
  return beginning;
}

// libedit waits for keys through the session, so that the heartbeat continues. Exceptions must not
// pass through its C code: they are stored until it returns.
class Editor {
 public:
  explicit Editor(Context& context)
      : context_(context),
        grammar_(Grammar::Scope::sequence, vehicles_of(context)),
        edit_(el_init("lss-cli", stdin, stdout, stderr)),
        history_(history_init()) {
    if (edit_ == nullptr || history_ == nullptr)
      throw Failure(ExitCode::internal, "cannot edit lines here");
    HistEvent event{};
    history(history_, &event, H_SETSIZE, kHistoryLines);
    history(history_, &event, H_SETUNIQUE, 1);
    if (!history_file().empty()) history(history_, &event, H_LOAD, history_file().c_str());
    el_set(edit_, EL_CLIENTDATA, this);
    el_set(edit_, EL_HIST, history, history_);
    el_set(edit_, EL_EDITOR, "emacs");
    el_set(edit_, EL_PROMPT, prompt);
    el_set(edit_, EL_GETCFN, get_key);
    el_set(edit_, EL_ADDFN, "complete", "complete the word", complete);
    el_set(edit_, EL_BIND, "^I", "complete", nullptr);
  }
  ~Editor() {
    HistEvent event{};
    if (!history_file().empty()) history(history_, &event, H_SAVE, history_file().c_str());
    history_end(history_);
    el_end(edit_);
  }
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  // Empty at the end of input. Throws exceptions that were stored during the input.
  std::optional<std::string> read() {
    int count = 0;
    const char* line = el_gets(edit_, &count);
    if (thrown_) std::rethrow_exception(std::exchange(thrown_, nullptr));
    if (line == nullptr || count <= 0) return std::nullopt;
    HistEvent event{};
    if (*line != '\n') history(history_, &event, H_ENTER, line);
    return line;
  }

 private:
  static Editor& self(EditLine* edit) {
    void* data = nullptr;
    el_get(edit, EL_CLIENTDATA, &data);
    return *static_cast<Editor*>(data);
  }

  static const char* prompt(EditLine* edit) {
    Editor& editor = self(edit);
    const lss_Status& status = editor.context_.session().link().status();
    const bool operational = status.state == lss_STATE_OPERATIONAL;
    editor.prompt_ =
        fmt::format("{} {}> ", text(status.vehicle_id),
                    operational ? std::string(text(status.mode_name)) : state_name(status.state));
    return editor.prompt_.c_str();
  }

  static int get_key(EditLine* edit, wchar_t* key) {
    Editor& editor = self(edit);
    try {
      std::mbstate_t state{};
      while (true) {
        while (!editor.context_.session().pump_input(Clock::now() + seconds(1), STDIN_FILENO)) {
        }
        char byte = 0;
        if (::read(STDIN_FILENO, &byte, 1) != 1) return 0;
        if (std::mbrtowc(key, &byte, 1, &state) != static_cast<std::size_t>(-2)) return 1;
      }
    } catch (...) {
      editor.thrown_ = std::current_exception();
      return -1;
    }
  }

  static unsigned char complete(EditLine* edit, int) {
    const std::vector<std::string> words = words_before(*el_line(edit));
    const std::vector<std::string> found = self(edit).grammar_.candidates(words);
    if (found.empty()) return CC_ERROR;
    const std::string beginning =
        common_beginning(found).substr(words.back().size()) + (found.size() == 1 ? " " : "");
    if (!beginning.empty())
      return el_insertstr(edit, beginning.c_str()) == 0 ? CC_REFRESH : CC_ERROR;
    std::string list = "\n";
    for (const std::string& word : found) list += word + "  ";
    std::fputs((list + "\n").c_str(), stdout);
    return CC_REDISPLAY;
  }

  Context& context_;
  Grammar grammar_;
  EditLine* edit_;
  History* history_;
  std::string prompt_;
  std::exception_ptr thrown_;
};

// An error does not end the shell, unless the daemon is gone, or a second Ctrl-C came.
ExitCode in_shell(Context& context, const std::function<void()>& act) {
  try {
    act();
  } catch (const Failure& e) {
    if (e.code() == ExitCode::unreachable || context.session().has_left()) throw;
    context.output.fail(e);
    return e.code();
  }
  return ExitCode::completed;
}

ExitCode run_line(Context& context, const std::string& line) {
  return in_shell(context, [&] {
    for (const Step& step : parse_steps(context, line, "")) run_step(context, step);
  });
}

// Lines of a pipe or a file. Waits through the session, so that the heartbeat continues.
class PipedLines {
 public:
  explicit PipedLines(Session& session) : session_(session) {}

  // Empty at the end of input. Interrupted also by a signal that came since the last wait.
  std::optional<std::string> next() {
    session_.pump(Clock::now());
    std::size_t end = text_.find('\n');
    while (end == std::string::npos && read()) end = text_.find('\n');
    if (text_.empty()) return std::nullopt;
    std::string line = text_.substr(0, end);
    text_.erase(0, end == std::string::npos ? end : end + 1);
    return line;
  }

 private:
  bool read() {
    while (!session_.pump_input(Clock::now() + seconds(1), STDIN_FILENO)) {
    }
    std::array<char, 4096> buffer;
    const ssize_t count = ::read(STDIN_FILENO, buffer.data(), buffer.size());
    if (count > 0) text_.append(buffer.data(), static_cast<std::size_t>(count));
    return count > 0;
  }

  Session& session_;
  std::string text_;
};

// Every line, until a Ctrl-C; the code of the first that failed.
ExitCode run_piped(Context& context) {
  PipedLines lines(context.session());
  ExitCode code = ExitCode::completed;
  try {
    while (!context.was_interrupted()) {
      const std::optional<std::string> line = lines.next();
      if (!line) break;
      const ExitCode ended = run_line(context, *line);
      if (code == ExitCode::completed) code = ended;
    }
  } catch (const Interrupted&) {
    stop_attached(context, "interrupted");
    throw Failure(ExitCode::failed, "interrupted");
  }
  return code;
}

bool is_end(const std::string& line) { return line == "exit\n" || line == "quit\n"; }

void run_terminal(Context& context) {
  context.output.print(
      "Verbs as in lss-cli --help; Tab completes, Ctrl-C stops the vehicle, Ctrl-D stops it and "
      "leaves\n");
  Editor editor(context);
  while (true) {
    context.session().link().forget_interruption();
    try {
      const std::optional<std::string> line = editor.read();
      if (!line || is_end(*line)) return;
      if (*line == "help\n") {
        run_line(context, "--help");
      } else {
        run_line(context, *line);
      }
    } catch (const Interrupted&) {
      context.output.print("^C\n");
      in_shell(context, [&] { stop_attached(context, "interrupted"); });
    }
  }
}

}  // namespace

ExitCode run_shell(Context& context) {
  context.in_sequence = true;
  context.session();
  ExitCode code = ExitCode::completed;
  if (isatty(STDIN_FILENO) == 1) {
    run_terminal(context);
  } else {
    code = run_piped(context);
  }
  stop_attached(context, "leaving");
  return code;
}

}  // namespace lss::cli
