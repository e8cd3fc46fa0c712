"""The component for F Prime: its model by the tools of FPP, its C++ with a base made here."""

import re
import shutil
import subprocess

import pytest

from gyrostat.control import AttitudePID, CurrentMode
from gyrostat.core.files import write_texts
from gyrostat.exports import targets
from gyrostat.exports.fprime import component
from gyrostat.exports.target import renamed

PERIOD = 0.1
FRAMEWORK = """
module Fw {
  port Cmd
  port CmdReg
  port CmdResponse
  port Log
  port LogText
  port Time
  port Tlm
}
module Svc {
  port Sched(context: U32)
}
"""
"""Ports of the framework that the model names."""

BASE = """
#include <cstddef>
#include <cstdint>
#include <cstdio>
typedef std::uint32_t U32;
typedef std::uint32_t FwOpcodeType;
typedef int FwIndexType;
typedef std::size_t FwSizeType;
namespace Fw {
struct CmdResponse { enum T { OK, EXECUTION_ERROR }; };
}
namespace Gyrostat {
struct YawLawSampleStatus {
    enum T { GOOD, PARTIAL, NOT_FINITE };
    T e;
    explicit YawLawSampleStatus(T value) : e(value) {}
};
struct YawLawMeasurement {
    double attitude, rate, speed;
    double get_attitude() const { return attitude; }
    double get_rate() const { return rate; }
    double get_speed() const { return speed; }
};
struct YawLawCommand {
    double current = 0.0;
    void set_current(double value) { current = value; }
    void set_attitude_current(double) {}
    void set_friction_current(double) {}
};
class YawLawComponentBase {
  public:
    explicit YawLawComponentBase(const char*) {}
    virtual ~YawLawComponentBase() {}
    virtual void run_handler(FwIndexType, U32) = 0;
    virtual void measurementIn_handler(FwIndexType, const YawLawMeasurement&) = 0;
    virtual void RESET_CONTROLLER_cmdHandler(FwOpcodeType, U32) = 0;
  protected:
    bool isConnected_commandOut_OutputPort(FwIndexType) { return true; }
    void commandOut_out(FwIndexType, const YawLawCommand& value, const YawLawSampleStatus& status) {
        std::printf("%.17g %d\\n", value.current, static_cast<int>(status.e));
    }
    void cmdResponse_out(FwOpcodeType, U32, Fw::CmdResponse::T) { std::printf("reset\\n"); }
    void log_ACTIVITY_HI_ControllerReset() {}
    void log_WARNING_HI_SampleRejected(YawLawSampleStatus) { std::printf("rejected\\n"); }
    void log_WARNING_HI_SensorTimeout(U32 ticks) { std::printf("no sample for %u\\n", ticks); }
    void log_WARNING_HI_StepFailed() { std::printf("failed\\n"); }
    void tlmWrite_Ticks(U32) {}
    void tlmWrite_MissingSamples(U32) {}
    void tlmWrite_RejectedSamples(U32) {}
    void tlmWrite_SampleStatus(YawLawSampleStatus) {}
};
}
"""
"""What the autocoder of F Prime would write of the base class, as far as it is used."""

MAIN = """
#include "YawLaw.hpp"
#include <cmath>
int main() {
    Gyrostat::YawLaw law("yaw");
    Gyrostat::YawLawComponentBase& base = law;
    base.run_handler(0, 0);
    base.measurementIn_handler(0, {0.5, 0.0, 0.0});
    base.run_handler(0, 0);
    base.measurementIn_handler(0, {NAN, 0.0, 0.0});
    base.run_handler(0, 0);
    for (int k = 0; k < 5; ++k) { base.run_handler(0, 0); }
    base.RESET_CONTROLLER_cmdHandler(0, 0);
    base.measurementIn_handler(0, {0.25, 0.0, 0.0});
    base.run_handler(0, 0);
    return 0;
}
"""
# proportional gain 1 over motor constant 0.02; the last accepted command is held
PRINTED = """0 2
25 0
rejected
25 2
25 2
25 2
25 2
25 2
no sample for 5
25 2
reset
12.5 0
"""


@pytest.fixture(scope="module")
def files():
    """Files of the component of an attitude law."""
    target = targets.controller(CurrentMode(AttitudePID(1.0, 0.0, 0.0), 0.02), PERIOD)
    texts = component(renamed(target, "yaw_law"), "double", "Made by a test.")
    return {name.removeprefix("YawLaw/"): text for name, text in texts.items()}


@pytest.fixture
def folder(files, tmp_path):
    write_texts(tmp_path, files | {"framework.fpp": FRAMEWORK})
    return tmp_path


def test_the_component_commands_what_the_guarded_law_does(folder, tools):
    plus = shutil.which("g++") or shutil.which("c++")
    if plus is None:
        pytest.skip("found no C++ compiler")
    (folder / "YawLawComponentAc.hpp").write_text(f"#pragma once\n{BASE}", encoding="utf-8")
    (folder / "main.cpp").write_text(MAIN, encoding="utf-8")
    strict = ("-std=c++14", "-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror")
    law = ("-std=c99", "-ffp-contract=off", "-c", "flight/yaw_law.c")
    subprocess.run([tools.compiler(), *law], cwd=folder, check=True)
    parts = ("main.cpp", "YawLaw.cpp", "yaw_law.o", "-I", ".", "-lm", "-o", "main")
    subprocess.run([plus, *strict, *parts], cwd=folder, check=True)
    done = subprocess.run([folder / "main"], capture_output=True, text=True, check=True)
    assert done.stdout == PRINTED


@pytest.mark.parametrize("tool", ["fpp-check", "fpp-to-cpp"])
def test_the_model_is_one_of_fpp(folder, tool):
    if shutil.which(tool) is None:
        pytest.skip(f"found no {tool} (pip install fprime-fpp)")
    model = ["framework.fpp", "YawLaw.fpp"]
    options = {"fpp-check": model, "fpp-to-cpp": ["-t", "-i", *model]}[tool]
    done = subprocess.run([tool, *options], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    if tool == "fpp-to-cpp":
        template = (folder / "YawLaw.template.hpp").read_text(encoding="utf-8")
        assert handlers(template) == handlers((folder / "YawLaw.hpp").read_text(encoding="utf-8"))


def handlers(text):
    """Signatures of the functions that a component must have."""
    text = re.sub(r"//[^\n]*", "", text)
    found = re.findall(r"void\s+(\w+)\(([^)]*)\)\s*override", text)
    return sorted((name, re.sub(r"\s+", " ", parameters).strip()) for name, parameters in found)
