// @Name@: @title@
#ifndef GYROSTAT_@NAME@_HPP
#define GYROSTAT_@NAME@_HPP

#include "@Name@ComponentAc.hpp"

extern "C" {
#include "flight/@name@.h"
}

namespace Gyrostat {

//! Runs the flight module @name@ once in each tick; without dynamic memory.
class @Name@ final : public @Name@ComponentBase {
  public:
    //! Controller before its first sample, with the designed parameters
    explicit @Name@(const char* const compName);

    ~@Name@();

  private:
    //! Ticks without a sample after which an event is sent
    static constexpr U32 SENSOR_TIMEOUT_TICKS = 5;

    void run_handler(FwIndexType portNum, U32 context) override;

    void measurementIn_handler(FwIndexType portNum, const Gyrostat::@Name@Measurement& sample) override;

    void RESET_CONTROLLER_cmdHandler(FwOpcodeType opCode, U32 cmdSeq) override;

    //! Make the measurement one that the guard rejects
    void setMissing();

    //! Step of the controller; on failure the memory stays, and the command is the safe one
    void step();

    //! Count and report the sample of a tick
    void report();

    //! Send the command
    void send();

@members@
    bool m_isFresh = false;  //!< whether there is a sample for the next tick
    bool m_isReady = false;  //!< whether parameters and state could be set
    U32 m_ticks = 0;
    U32 m_missing = 0;
    U32 m_rejected = 0;
    U32 m_ticksWithoutSample = 0;
};

}  // namespace Gyrostat

#endif
