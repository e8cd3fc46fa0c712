// @Name@: @title@
#include "@Name@.hpp"

#include <cmath>
#include <cstring>

namespace Gyrostat {

@fill@@Name@ ::@Name@(const char* const compName) : @Name@ComponentBase(compName) {
    int fault = 0;
@parameters@
@start@
    this->m_isReady = (fault == 0);
}

@Name@ ::~@Name@() {}

void @Name@ ::measurementIn_handler(FwIndexType portNum, const Gyrostat::@Name@Measurement& sample) {
    static_cast<void>(portNum);
@inputs@
    this->m_isFresh = true;
}

void @Name@ ::RESET_CONTROLLER_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) {
    int fault = 0;
@start@
    this->m_isReady = (fault == 0);
    this->log_ACTIVITY_HI_ControllerReset();
    this->cmdResponse_out(opCode, cmdSeq, this->m_isReady ? Fw::CmdResponse::OK : Fw::CmdResponse::EXECUTION_ERROR);
}

void @Name@ ::run_handler(FwIndexType portNum, U32 context) {
    static_cast<void>(portNum);
    static_cast<void>(context);
    ++this->m_ticks;
    if (this->m_isFresh) {
        this->m_ticksWithoutSample = 0;
    } else {
        this->setMissing();
        ++this->m_missing;
        ++this->m_ticksWithoutSample;
    }
    this->step();
    this->report();
    this->m_isFresh = false;
    this->send();
}

void @Name@ ::step() {
@last_memory@
@last_command@
    int fault = this->m_isReady ? 0 : 1;

    (void)std::memcpy(&lastMemory, &this->m_memory, sizeof(lastMemory));
    (void)std::memcpy(&lastCommand, &this->m_command, sizeof(lastCommand));
    if (fault == 0) {
@step@
    }
    if (fault != 0) {
        (void)std::memcpy(&this->m_memory, &lastMemory, sizeof(lastMemory));
        @safe@
        this->m_report.sample_status = SAMPLE_STATUS_NOT_COMPUTED;
        this->log_WARNING_HI_StepFailed();
    }
}

void @Name@ ::report() {
    const @Name@SampleStatus status(static_cast<@Name@SampleStatus::T>(this->m_report.sample_status));

    if (this->m_isFresh && (this->m_report.sample_status != SAMPLE_STATUS_GOOD)) {
        ++this->m_rejected;
        this->log_WARNING_HI_SampleRejected(status);
    }
    if (this->m_ticksWithoutSample == SENSOR_TIMEOUT_TICKS) {
        this->log_WARNING_HI_SensorTimeout(this->m_ticksWithoutSample);
    }
    this->tlmWrite_Ticks(this->m_ticks);
    this->tlmWrite_MissingSamples(this->m_missing);
    this->tlmWrite_RejectedSamples(this->m_rejected);
    this->tlmWrite_SampleStatus(status);
}

void @Name@ ::send() {
    @Name@Command value;
    const @Name@SampleStatus status(static_cast<@Name@SampleStatus::T>(this->m_report.sample_status));

@outputs@
    if (this->isConnected_commandOut_OutputPort(0)) {
        this->commandOut_out(0, value, status);
    }
}

void @Name@ ::setMissing() {
@missing@
}

}  // namespace Gyrostat
