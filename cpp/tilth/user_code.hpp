// SPDX-License-Identifier: BSD-3-Clause
// Code of the user in this process: if it ends the process (exit, a Fortran STOP, abort, a crash),
// the process says which code it was, and ends with the exit code of a failed analysis.
#pragma once

#include <fcntl.h>
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <mutex>
#include <string>

namespace tilth::user_code {

/// Name of the user's code that this thread runs; null outside of it. Signal handlers read it.
[[gnu::tls_model("initial-exec")]] inline constinit thread_local const char* running = nullptr;

/// What is said besides the name of the code: what is left of a run, empty for nothing. `file` gets
/// a line, too; -1 for none.
struct Note {
  std::string kept;
  int file = -1;
};

inline std::atomic<const Note*> note{nullptr};

inline constexpr int exit_code = 1;  // EXIT_ANALYSIS_FAILED in src/tilth/errors.py

inline constexpr const char* remedy = "correct it: it must return to tilth, whatever it finds";

inline void put(int file, const char* text) noexcept {
  std::size_t left = std::strlen(text);
  while (left > 0) {
    const ssize_t written = ::write(file, text, left);
    if (written <= 0) return;
    text += written;
    left -= static_cast<std::size_t>(written);
  }
}

/// Ends the process with a message about the code that runs: `how` it ended, and `detail`. Only
/// calls what a signal handler may call.
[[noreturn]] inline void end(const char* how, const char* detail = "") noexcept {
  static std::atomic_flag ending = ATOMIC_FLAG_INIT;
  while (ending.test_and_set()) ::pause();  // another thread says it
  const Note* said = note.load();
  if (::isatty(STDOUT_FILENO)) put(STDOUT_FILENO, "\x1b[?25h");  // the cursor, of a progress bar
  for (const char* part : {"\n", running, " ", how, detail, "\n  "}) put(STDERR_FILENO, part);
  put(STDERR_FILENO, remedy);
  if (said != nullptr && !said->kept.empty())
    for (const char* part : {"; ", said->kept.c_str()}) put(STDERR_FILENO, part);
  put(STDERR_FILENO, "\n");
  if (said != nullptr && said->file >= 0)
    for (const char* part : {"\nstopped: ", running, " ", how, detail, "\n"}) put(said->file, part);
  ::_exit(exit_code);
}

/// A stack for signal handlers of this thread: its own may have overflowed.
class HandlerStack {
 public:
  HandlerStack() {
    stack_t now{};
    if (::sigaltstack(nullptr, &now) != 0 || !(now.ss_flags & SS_DISABLE)) return;
    memory_ = std::make_unique<char[]>(size);
    now.ss_sp = memory_.get();
    now.ss_size = size;
    now.ss_flags = 0;
    ::sigaltstack(&now, nullptr);
  }
  ~HandlerStack() {
    if (memory_ == nullptr) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    ::sigaltstack(&none, nullptr);
  }
  HandlerStack(const HandlerStack&) = delete;
  HandlerStack& operator=(const HandlerStack&) = delete;

 private:
  static constexpr std::size_t size = 65536;
  std::unique_ptr<char[]> memory_;
};

/// Names the code that this thread runs, as long as it lives; `name` must live longer.
class Running {
 public:
  explicit Running(const char* name) : before_(running) {
    static thread_local HandlerStack stack;
    running = name;
  }
  ~Running() { running = before_; }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

 private:
  const char* before_;
};

/// Watches how the process ends, as long as it lives: by a fatal signal or by `exit`. Signals that
/// do not come from the user's code are left to the handlers of before.
class Watch {
 public:
  Watch() {
    process = ::getpid();
    const std::lock_guard lock(mutex());
    if (count++ > 0) return;
    watch_exit();
    struct sigaction own{};
    own.sa_handler = on_signal;
    own.sa_flags = SA_ONSTACK;
    for (std::size_t i = 0; i < fatal.size(); ++i) ::sigaction(fatal[i], &own, &before[i]);
  }
  ~Watch() {
    const std::lock_guard lock(mutex());
    if (--count > 0) return;
    for (std::size_t i = 0; i < fatal.size(); ++i) ::sigaction(fatal[i], &before[i], nullptr);
  }
  Watch(const Watch&) = delete;
  Watch& operator=(const Watch&) = delete;

 private:
  static constexpr std::array fatal{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
  inline static std::array<struct sigaction, fatal.size()> before{};
  inline static int count = 0;
  inline static std::atomic<pid_t> process = 0;

  static std::mutex& mutex() {
    static std::mutex only;
    return only;
  }

  static void on_signal(int number) {
    if (running != nullptr) end("crashed: ", meaning(number));
    for (std::size_t i = 0; i < fatal.size(); ++i)
      if (fatal[i] == number) ::sigaction(number, &before[i], nullptr);
    ::raise(number);
  }

  static const char* meaning(int number) {
    switch (number) {
      case SIGABRT:
        return "it called abort, or a check of the system library failed (SIGABRT)";
      case SIGFPE:
        return "it divided by zero or overflowed (SIGFPE)";
      case SIGILL:
        return "it has an instruction that this processor lacks (SIGILL)";
      default:
        return "it used memory that is not its own, or more of the stack than there is "
               "(SIGSEGV; OMP_STACKSIZE sets that of threads)";
    }
  }

  /// `exit` of a child process of the user's code is none of ours.
  static void watch_exit() {
    static const auto said = [] {
      if (running == nullptr || ::getpid() != process) return;
      std::fflush(nullptr);  // what the code has printed
      end("ended the program, as exit, STOP and XIT do");
    };
    static const bool is_watched = std::atexit(said) == 0 && std::at_quick_exit(said) == 0;
    static_cast<void>(is_watched);
  }
};

/// Goes back to the present working folder at the end of its life.
class KeptFolder {
 public:
  KeptFolder() : folder_(::open(".", O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {}
  ~KeptFolder() {
    if (folder_ < 0) return;
    if (::fchdir(folder_) != 0) put(STDERR_FILENO, "tilth: the working folder is lost\n");
    ::close(folder_);
  }
  KeptFolder(const KeptFolder&) = delete;
  KeptFolder& operator=(const KeptFolder&) = delete;

 private:
  int folder_;
};

/// Around many calls of the user's code.
class Around {
  Watch watch_;
  KeptFolder folder_;
};

/// Returns what a compiled function of the user returns; an exception of it ends the process, for
/// no exception can pass through C.
template <class Call>
auto call(const char* name, Call&& function) {
  const Running here(name);
  try {
    return function();
  } catch (const std::exception& error) {
    end("threw a C++ exception: ", error.what());
  } catch (...) {
    end("threw an exception or ended its thread");
  }
}

}  // namespace tilth::user_code
