# @Name@: @title@
module Gyrostat {

  @ Status of a sample, see SampleStatus in flight/@name@.h
  enum @Name@SampleStatus {
@statuses@
  }

  @ One sample of all measurements
  struct @Name@Measurement {
@measurement@
  }

  @ Command of a tick
  struct @Name@Command {
@command@
  }

  port @Name@MeasurementPort($sample: @Name@Measurement)

  port @Name@CommandPort($value: @Name@Command, $status: @Name@SampleStatus)

  @ @title@
  passive component @Name@ {

    @ One tick: a rate group calls it every @period@ s
    guarded input port run: Svc.Sched

    @ Sample for the next tick; the last one before it counts
    guarded input port measurementIn: @Name@MeasurementPort

    @ Command of a tick
    output port commandOut: @Name@CommandPort

    command recv port cmdIn
    command reg port cmdRegOut
    command resp port cmdResponseOut
    event port eventOut
    text event port textEventOut
    telemetry port tlmOut
    time get port timeGetOut

    @ Set the controller to its state before the first sample
    guarded command RESET_CONTROLLER opcode 0

    @ The controller was reset
    event ControllerReset severity activity high id 0 format "controller reset"

    @ The guard rejected a sample, or values of it
    event SampleRejected($status: @Name@SampleStatus) \
      severity warning high id 1 format "sample of status {}" throttle 10

    @ No sample for a number of ticks
    event SensorTimeout(ticks: U32) severity warning high id 2 format "no sample for {} ticks" throttle 10

    @ A step of the controller failed; the command is the safe one
    event StepFailed severity warning high id 3 format "step failed" throttle 10

    @ Ticks since the start
    telemetry Ticks: U32 id 0

    @ Ticks without a sample
    telemetry MissingSamples: U32 id 1

    @ Samples that the guard rejected, or values of them
    telemetry RejectedSamples: U32 id 2

    @ Status of the last sample
    telemetry SampleStatus: @Name@SampleStatus id 3

  }

}
