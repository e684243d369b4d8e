// A program under test that runs beside the test, to be stopped.
#ifndef CLOTHID_TESTS_TOOLS_TOOL_PROCESS_H_
#define CLOTHID_TESTS_TOOLS_TOOL_PROCESS_H_

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace clothid {

// One of our programs, in `folder`, with a process id of its own.
class ToolProcess {
 public:
  ToolProcess(const std::string& program, const std::filesystem::path& folder, const std::vector<std::string>& flags) {
    std::vector<std::string> words = {CLOTHID_BINARY_DIR "/" + program};
    words.insert(words.end(), flags.begin(), flags.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    process_ = ::fork();
    if (process_ == 0) {
      const int null = ::open("/dev/null", O_WRONLY);
      if (null < 0 || ::dup2(null, 1) < 0 || ::dup2(null, 2) < 0 || ::chdir(folder.c_str()) != 0) ::_exit(127);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    EXPECT_GT(process_, 0);
  }

  bool IsRunning() const {
    siginfo_t info = {};
    return ::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
  }
  // Whether it has a handler of its own for `signal` (SigCgt of proc(5)).
  bool Catches(int signal) const {
    std::ifstream status("/proc/" + std::to_string(process_) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind("SigCgt:", 0) == 0) return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
    }
    return false;
  }
  void Signal(int signal) const { ::kill(process_, signal); }
  // The exit code; nothing where a signal ended it.
  std::optional<int> Wait() const {
    int status = 0;
    EXPECT_EQ(::waitpid(process_, &status, 0), process_);
    return WIFEXITED(status) ? std::optional<int>(WEXITSTATUS(status)) : std::nullopt;
  }

 private:
  pid_t process_ = -1;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_TOOLS_TOOL_PROCESS_H_
