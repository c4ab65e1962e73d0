#pragma once

// The Unix stream socket of an OBC that polls, with one connection: a new one replaces the old one.
// Never blocks; main thread only. Errors at the start are thrown as a Failure.

#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/obc/frame.h"

namespace lss::cli::obc {

class Socket {
 public:
  // Replaces the file of a process that has ended. Mode 0660; `group`: of the file, empty: the
  // group of this process.
  Socket(std::string path, const std::string& group);
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  // Readable when take() has something to do.
  int fd() const { return epoll_; }

  struct News {
    bool connected = false;  // by somebody new; the lines are theirs
    std::vector<Lines::Line> lines;
  };
  News take();
  // Nothing without a connection. One that does not read its replies is closed.
  void send(std::string_view text);

 private:
  void open(const std::string& group);
  void connect(int client);
  void disconnect();
  void flush();
  void watch(int operation, int fd, bool writes) const;

  std::string path_;
  int listener_ = -1, epoll_ = -1, client_ = -1;
  Lines lines_;
  std::string unsent_;
};

}  // namespace lss::cli::obc
