#include "browser.h"

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fcntl.h>
#include <map>
#include <poll.h>
#include <spawn.h>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "output/files/json_text.h"

extern char** environ;

namespace test {

using insitu::output::JsonText;

std::string find_chromium() {
  std::istringstream folders(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"})
      if (::access((folder + "/" + name).c_str(), X_OK) == 0)
        return folder + "/" + name;
  return {};
}

Browser::Browser(const std::string& program) {
  int down[2], up[2]; // it reads requests from descriptor 3 and answers on 4
  if (::pipe2(down, O_CLOEXEC) != 0 || ::pipe2(up, O_CLOEXEC) != 0)
    throw std::runtime_error("no pipes");
  // Away from 3 and 4, which dup2 would leave close-on-exec if they were the same.
  const int read_end = ::fcntl(down[0], F_DUPFD_CLOEXEC, 10);
  const int write_end = ::fcntl(up[1], F_DUPFD_CLOEXEC, 10);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, read_end, 3);
  posix_spawn_file_actions_adddup2(&actions, write_end, 4);
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_WRONLY, 0);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP); // it starts others
  std::vector<std::string> words{program,
                                 "--headless",
                                 "--no-sandbox", // as root it has none
                                 "--disable-gpu",
                                 "--hide-scrollbars",
                                 "--no-first-run",
                                 "--disable-dev-shm-usage",
                                 "--remote-debugging-pipe",
                                 "--user-data-dir=" + profile_.path(),
                                 "about:blank"};
  std::vector<char*> arguments;
  for (std::string& w : words)
    arguments.push_back(w.data());
  arguments.push_back(nullptr);
  const int error =
      ::posix_spawn(&child_, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  for (const int end : {down[0], up[1], read_end, write_end})
    ::close(end);
  to_ = down[1];
  from_ = up[0];
  if (error != 0)
    throw std::runtime_error(program + " does not start");
  ::signal(SIGPIPE, SIG_IGN);
  const YAML::Node target = call("Target.createTarget", R"({"url": "about:blank"})");
  JsonText j;
  j.open('{').key("targetId").value(target["targetId"].as<std::string>());
  j.key("flatten").value(true).close();
  session_ = call("Target.attachToTarget", j.text())["sessionId"].as<std::string>();
  for (const char* domain : {"Page", "Runtime", "Log", "Network"})
    call(std::string(domain) + ".enable");
}

Browser::~Browser() {
  if (child_ > 0) {
    ::kill(-child_, SIGKILL); // the group that it leads: its own processes
    ::waitpid(child_, nullptr, 0);
  }
  ::close(to_);
  ::close(from_);
}

YAML::Node Browser::receive() {
  std::size_t end;
  while ((end = buffer_.find('\0')) == std::string::npos) {
    pollfd ready{from_, POLLIN, 0};
    char block[1 << 16];
    const ssize_t count = ::poll(&ready, 1, 60'000) > 0 ? ::read(from_, block, sizeof block) : 0;
    if (count <= 0)
      throw std::runtime_error("the browser does not answer");
    buffer_.append(block, std::size_t(count));
  }
  const YAML::Node message = YAML::Load(buffer_.substr(0, end)); // JSON is YAML
  buffer_.erase(0, end + 1);
  return message;
}

void Browser::note(const YAML::Node& event) {
  const std::string method = event["method"].as<std::string>("");
  const YAML::Node about = event["params"];
  if (method == "Runtime.exceptionThrown")
    problems.push_back(about["exceptionDetails"]["exception"]["description"].as<std::string>(
        about["exceptionDetails"]["text"].as<std::string>("an exception")));
  else if (method == "Log.entryAdded" && about["entry"]["level"].as<std::string>("") == "error")
    problems.push_back(about["entry"]["text"].as<std::string>("") + " " +
                       about["entry"]["url"].as<std::string>(""));
  else if (method == "Network.requestWillBeSent")
    requests.push_back(about["request"]["url"].as<std::string>(""));
}

YAML::Node Browser::call(const std::string& method, const std::string& parameters) {
  JsonText j;
  j.open('{').key("id").value(++last_id_).key("method").value(method).key("params").raw(parameters);
  if (!session_.empty())
    j.key("sessionId").value(session_);
  const std::string text = j.close().text() + '\0';
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = ::write(to_, text.data() + done, text.size() - done);
    if (count <= 0)
      throw std::runtime_error("the browser does not listen");
    done += std::size_t(count);
  }
  for (;;) {
    const YAML::Node message = receive();
    if (message["id"].as<int>(0) == last_id_) {
      if (message["error"])
        throw std::runtime_error(method + ": " + message["error"]["message"].as<std::string>());
      return message["result"];
    }
    note(message);
  }
}

void Browser::open(const std::string& path) {
  problems.clear();
  requests.clear();
  JsonText j;
  j.open('{').key("url").value("file://" + path).close();
  call("Page.navigate", j.text());
  if (!wait("document.readyState === 'complete' && location.protocol === 'file:'", 30))
    throw std::runtime_error(path + " does not load");
}

void Browser::size(int width, int height) {
  JsonText j;
  j.open('{').key("width").value(width).key("height").value(height);
  j.key("deviceScaleFactor").value(1).key("mobile").value(false).close();
  call("Emulation.setDeviceMetricsOverride", j.text());
}

void Browser::dark(bool on) {
  JsonText j;
  j.open('{').key("features").open('[').open('{').key("name").value("prefers-color-scheme");
  j.key("value").value(on ? "dark" : "light").close().close().close();
  call("Emulation.setEmulatedMedia", j.text());
}

YAML::Node Browser::evaluate(const std::string& expression) {
  JsonText j;
  j.open('{').key("expression").value(expression);
  j.key("returnByValue").value(true).key("awaitPromise").value(true).close();
  const YAML::Node answer = call("Runtime.evaluate", j.text());
  if (answer["exceptionDetails"])
    throw std::runtime_error(
        expression + ": " +
        answer["exceptionDetails"]["exception"]["description"].as<std::string>("throws"));
  return answer["result"]["value"];
}

bool Browser::wait(const std::string& expression, double seconds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  do {
    if (evaluate("!!(" + expression + ")").as<bool>())
      return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  } while (std::chrono::steady_clock::now() < until);
  return false;
}

void Browser::click(const std::string& selector, double across) {
  const YAML::Node box =
      evaluate("(() => { const e = document.querySelector(" + JsonText().value(selector).text() +
               "); e.scrollIntoView({block: 'center', behavior: 'instant'}); const b = "
               "e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()");
  const double x = box[0].as<double>() +
                   std::max(1.0, std::min(box[2].as<double>() - 1, box[2].as<double>() * across));
  const double y = box[1].as<double>() + box[3].as<double>() / 2;
  for (const char* type : {"mouseMoved", "mousePressed", "mouseReleased"}) {
    JsonText j;
    j.open('{').key("type").value(type).key("x").value(x).key("y").value(y);
    j.key("button").value(std::string_view(type) == "mouseMoved" ? "none" : "left");
    j.key("clickCount").value(1).close();
    call("Input.dispatchMouseEvent", j.text());
  }
}

void Browser::press(const std::string& key) {
  static const std::map<std::string, int> codes{{"ArrowLeft", 37}, {"ArrowRight", 39}, {"Home", 36},
                                                {"End", 35},       {"Enter", 13},      {"Tab", 9}};
  for (const char* type : {"keyDown", "keyUp"}) {
    JsonText j;
    j.open('{').key("type").value(type).key("key").value(key).key("code").value(key);
    j.key("windowsVirtualKeyCode").value(codes.at(key)).close();
    call("Input.dispatchKeyEvent", j.text());
  }
}

void Browser::screenshot(const std::string& path) {
  const std::string data =
      call("Page.captureScreenshot", R"({"captureBeyondViewport": true})")["data"]
          .as<std::string>();
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : data) { // base64
    const auto digit = std::string_view("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz"
                                        "0123456789+/")
                           .find(c);
    if (digit == std::string_view::npos)
      break;
    bits = bits << 6 | unsigned(digit);
    if ((count += 6) >= 8)
      bytes += char(bits >> (count -= 8) & 0xff);
  }
  put(path, bytes);
}

} // namespace test
