// A headless Chromium under test, driven through the pipes of its DevTools protocol: no driver, no port.
#ifndef CLOTHID_TESTS_IDENTIFY_REPORT_BROWSER_H_
#define CLOTHID_TESTS_IDENTIFY_REPORT_BROWSER_H_

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/temporary_folder.h"

namespace clothid {

// Where a Chromium is installed: CHROMIUM, or on the path. Nothing where there is none.
inline std::optional<std::string> FindChromium() {
  if (const char* chosen = std::getenv("CHROMIUM")) return chosen;
  for (const char* name : {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"}) {
    if (std::filesystem::exists(name)) return name;
  }
  return std::nullopt;
}

class Browser {
 public:
  using Json = nlohmann::json;

  // Throws std::runtime_error where the browser does not answer, here as in all that follows.
  explicit Browser(const std::string& program) {
    Start(program, {"--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--use-angle=swiftshader",
                    "--enable-unsafe-swiftshader", "--disable-gpu-compositing", "--num-raster-threads=1",
                    "--disable-dev-shm-usage", "--no-first-run", "--hide-scrollbars", "--disable-background-networking",
                    "--disable-component-update", "--force-device-scale-factor=1", "--window-size=1200,900",
                    "--user-data-dir=" + profile_.path(), "about:blank"});
  }

  // A new page of that size, about which nothing is known yet; the one before is closed.
  void OpenPage(int width, int height) {
    session_.clear();
    if (!target_.empty()) Call("Target.closeTarget", {{"targetId", target_}});
    target_ = Call("Target.createTarget", {{"url", "about:blank"}})["targetId"];
    session_ = Call("Target.attachToTarget", {{"targetId", target_}, {"flatten", true}})["sessionId"];
    complaints_.clear();
    requests_.clear();
    for (const char* domain : {"Page", "Runtime", "Network", "Log"}) Call(std::string(domain) + ".enable");
    Call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
  }

  // Opens a file and waits until `condition`, an expression of the page, holds.
  void Open(const std::string& path, const std::string& condition) {
    Call("Page.navigate", {{"url", "file://" + path}});
    WaitUntil(condition);
  }

  void WaitUntil(const std::string& condition) {
    const auto start = std::chrono::steady_clock::now();
    // While a page loads there may be nothing to ask.
    const std::string expression = "(() => { try { return !!(" + condition + "); } catch { return false; } })()";
    while (Evaluate(expression) != true) {
      if (std::chrono::steady_clock::now() - start > kPatience) throw std::runtime_error("never true: " + condition);
      ::usleep(20000);
    }
  }

  // The value of an expression, or of the promise that it is.
  Json Evaluate(const std::string& expression) {
    const Json answer =
        Call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
    if (answer.contains("exceptionDetails")) throw std::runtime_error(expression + ": " + answer.dump());
    return answer["result"].value("value", Json());
  }

  // Makes the window as large as that.
  void Resize(int width, int height) {
    Call("Emulation.setDeviceMetricsOverride",
         {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
    WaitUntil("innerWidth === " + std::to_string(width));
    WaitForFrames();
  }

  // From now on pages are held in the hand, also those that are opened later.
  void UseFingers() { Call("Emulation.setTouchEmulationEnabled", {{"enabled", true}, {"maxTouchPoints", 2}}); }

  // Fingers come down, move and leave again: [x, y] px of each, one array per moment.
  void Touch(const std::vector<Json>& moments) {
    for (std::size_t i = 0; i <= moments.size(); ++i) {
      Json points = Json::array();
      if (i < moments.size()) {
        for (const Json& point : moments[i])
          points.push_back({{"x", point[0]}, {"y", point[1]}, {"id", points.size()}});
      }
      const char* type = i == 0 ? "touchStart" : i < moments.size() ? "touchMove" : "touchEnd";
      Call("Input.dispatchTouchEvent", {{"type", type}, {"touchPoints", points}});
    }
    WaitForFrames();
  }

  // Two frames later, all that was asked for has been drawn.
  void WaitForFrames() { Evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"); }

  // What stands out of the window, or of the card that it is in, at its right; one line each.
  std::string WhatStandsOut() {
    return Evaluate(R"((() => {
      const found = [], page = document.documentElement;
      if (page.scrollWidth > innerWidth) found.push(`the page: ${page.scrollWidth} of ${innerWidth} px`);
      for (const box of document.querySelectorAll('.card, .tile, .stacked td, .described td, .plot, .lines, .views > *')) {
        if (box.clientWidth === 0 || box.scrollWidth <= box.clientWidth + 1) continue;
        found.push(`${box.tagName} ${box.id} ${box.className}: ${box.scrollWidth} of ${box.clientWidth} px`);
      }
      return found.join('\n');
    })())");
  }

  // Controls that are too low for a finger, one line each.
  std::string WhatIsTooSmall() {
    return Evaluate(R"([...document.querySelectorAll('button, select, summary, input[type=range], label')]
      .filter((made) => made.offsetWidth > 0 && made.getBoundingClientRect().height < 40)
      .map((made) => `${made.tagName} ${made.id} ${made.textContent}`).join('\n'))");
  }

  // A click of the mouse on the middle of an element.
  void Click(const std::string& id) {
    const Json box = Evaluate("(() => { const e = document.getElementById('" + id +
                              "'); e.scrollIntoView({block: " + "'center'}); const b = e.getBoundingClientRect(); " +
                              "return [b.left + b.width / 2, b.top + b.height / 2]; })()");
    for (const char* type : {"mousePressed", "mouseReleased"}) {
      Call("Input.dispatchMouseEvent",
           {{"type", type}, {"x", box[0]}, {"y", box[1]}, {"button", "left"}, {"clickCount", 1}});
    }
  }

  // What the screen shows of an element, PNG in base64.
  std::string Picture(const std::string& id) {
    const Json box =
        Evaluate("(() => { const e = document.getElementById('" + id + "'); e.scrollIntoView({block: " +
                 "'center'}); const b = e.getBoundingClientRect(); return {x: b.left + scrollX, y: b.top " +
                 "+ scrollY, width: b.width, height: b.height, scale: 1}; })()");
    return Call("Page.captureScreenshot", {{"format", "png"}, {"clip", box}})["data"];
  }

  // Errors and warnings on the console, exceptions, and whatever a policy has blocked.
  const std::vector<std::string>& complaints() const { return complaints_; }
  // Addresses that were asked for, beside files and what pages hold themselves.
  const std::vector<std::string>& requests() const { return requests_; }

 private:
  static constexpr std::chrono::seconds kPatience{40};

  // The browser, and all that it has started; ends with this object.
  struct Process {
    pid_t id = -1;
    int input = -1, output = -1;

    Process() = default;
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process() {
      if (id <= 0) return;
      ::close(input);
      ::close(output);
      ::kill(-id, SIGKILL);
      ::waitpid(id, nullptr, 0);
    }
  };

  void Start(const std::string& program, const std::vector<std::string>& flags) {
    int in[2], out[2];
    if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) throw std::runtime_error("no pipes");
    std::vector<char*> arguments = {const_cast<char*>(program.c_str())};
    for (const std::string& flag : flags) arguments.push_back(const_cast<char*>(flag.c_str()));
    arguments.push_back(nullptr);
    process_.id = ::fork();
    if (process_.id == 0) {
      ::setpgid(0, 0);  // a group with all that it starts
      // Out of the way of 3 and 4, where the browser reads and writes.
      const int read = ::fcntl(in[0], F_DUPFD, 10), write = ::fcntl(out[1], F_DUPFD, 10);
      const int null = ::open("/dev/null", O_RDWR);
      for (const int standard : {0, 1, 2}) ::dup2(null, standard);
      ::dup2(read, 3);
      ::dup2(write, 4);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    if (process_.id < 0) throw std::runtime_error("no process");
    ::setpgid(process_.id, process_.id);  // whoever is first
    ::signal(SIGPIPE, SIG_IGN);           // writing to a browser that has ended is an error like others
    ::close(in[0]);
    ::close(out[1]);
    process_.input = in[1];
    process_.output = out[0];
  }

  // The result of one command.
  Json Call(const std::string& method, const Json& parameters = Json::object()) {
    const int id = ++last_id_;
    Json command = {{"id", id}, {"method", method}, {"params", parameters}};
    if (!session_.empty()) command["sessionId"] = session_;
    const std::string text = command.dump() + '\0';
    if (::write(process_.input, text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
      throw std::runtime_error("the browser has ended");
    }
    while (true) {
      const Json message = Read();
      if (message.value("id", 0) != id) {
        Note(message);
        continue;
      }
      if (message.contains("error")) throw std::runtime_error(method + ": " + message["error"].dump());
      return message["result"];
    }
  }

  Json Read() {
    while (true) {
      const std::size_t end = received_.find('\0');
      if (end != std::string::npos) {
        const Json message = Json::parse(received_.substr(0, end));
        received_.erase(0, end + 1);
        return message;
      }
      pollfd waiting = {process_.output, POLLIN, 0};
      const int limit = static_cast<int>(std::chrono::milliseconds(kPatience).count());
      if (::poll(&waiting, 1, limit) != 1) throw std::runtime_error("the browser does not answer");
      char bytes[65536];
      const ssize_t count = ::read(process_.output, bytes, sizeof(bytes));
      if (count <= 0) throw std::runtime_error("the browser has ended");
      received_.append(bytes, static_cast<std::size_t>(count));
    }
  }

  void Note(const Json& message) {
    const std::string method = message.value("method", "");
    const Json parameters = message.value("params", Json::object());
    if (method == "Runtime.exceptionThrown") complaints_.push_back(parameters["exceptionDetails"].dump());
    if (method == "Runtime.consoleAPICalled" && (parameters["type"] == "error" || parameters["type"] == "warning")) {
      complaints_.push_back(parameters["args"].dump());
    }
    if (method == "Log.entryAdded" && (parameters["entry"]["level"] == "error")) {
      complaints_.push_back(parameters["entry"].dump());
    }
    if (method != "Network.requestWillBeSent") return;
    const std::string address = parameters["request"]["url"];
    for (const char* own : {"file:", "data:", "blob:"}) {
      if (address.rfind(own, 0) == 0) return;
    }
    requests_.push_back(address);
  }

  TemporaryFolder profile_;
  Process process_;
  int last_id_ = 0;
  std::string target_, session_, received_;  // of the page; what came in and was not read yet
  std::vector<std::string> complaints_, requests_;
};

}  // namespace clothid

#endif  // CLOTHID_TESTS_IDENTIFY_REPORT_BROWSER_H_
