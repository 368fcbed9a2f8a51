// SPDX-License-Identifier: MIT
#include "studies/sweep/processes.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <map>
#include <memory>
#include <spawn.h>
#include <sys/wait.h>
#include <system_error>

#include "common/stop.hpp"

extern char **environ;

namespace sixdeg {
namespace {

constexpr std::size_t kErrorsKept = 64 * 1024;

struct Close {
    void operator()(std::FILE *file) const { std::fclose(file); }
};

struct Child {
    std::size_t index;
    std::unique_ptr<std::FILE, Close> errors; // an unnamed file: a full pipe would stop the child
};

[[noreturn]] void fail(int code, const std::string &what) {
    throw std::system_error(code, std::generic_category(), what);
}

pid_t start(const std::vector<std::string> &command, std::FILE *errors) {
    std::vector<char *> arguments;
    for (const std::string &argument : command) arguments.push_back(const_cast<char *>(argument.c_str()));
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(errors), 2);
    pid_t child = 0;
    const int code = posix_spawn(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (code != 0) fail(code, command[0]);
    return child;
}

std::string whole(std::FILE *file) {
    std::string text(kErrorsKept, '\0');
    std::rewind(file);
    text.resize(std::fread(text.data(), 1, text.size(), file));
    return text;
}

} // namespace

void run_all(const std::vector<std::vector<std::string>> &commands, std::size_t jobs,
             const std::function<bool(const Ended &)> &ended) {
    std::map<pid_t, Child> running;
    std::size_t next = 0;
    bool more = true;
    while (true) {
        while (more && stop_signal() == 0 && next < commands.size() && running.size() < std::max<std::size_t>(jobs, 1)) {
            Child child{next, std::unique_ptr<std::FILE, Close>(std::tmpfile())};
            if (!child.errors) fail(errno, "temporary file");
            const pid_t id = start(commands[next++], child.errors.get());
            running.emplace(id, std::move(child));
        }
        if (running.empty()) return;
        int status = 0;
        const pid_t id = waitpid(-1, &status, 0);
        if (id < 0 && errno == EINTR) continue;
        const auto child = running.find(id);
        if (child == running.end()) continue;
        const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        more = ended({child->second.index, code, whole(child->second.errors.get())}) && more;
        running.erase(child);
    }
}

} // namespace sixdeg
