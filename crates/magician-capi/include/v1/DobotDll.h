/*
 * The vendor's C interface to the Dobot Magician, under the vendor's names.
 *
 * Functions have no ids: a program has one arm. See DobotType.h for the structures and what is returned.
 *
 * Any function may be called from any thread. It returns when the arm has answered, or after SetCmdTimeout's time.
 * Results are written only when 0 is returned. MagicianLastError has a sentence for every other number.
 *
 * Commands with isQueued are carried out one after the other, when their turn comes: queuedCmdIndex, which may be NULL,
 * gets the command's index, and the command has ended when GetQueuedCmdCurrentIndex is not less. [always queued] says
 * that isQueued is not looked at, as in the vendor's library. [guarded] commands are refused with
 * DobotCommunicate_InvalidParams until MagicianAllow or the environment's MAGICIAN_ALLOW names them. [not this arm] says
 * that the function is for other machines: it does nothing, returns 0, and its results are zero.
 */
#ifndef DOBOTDLL_H
#define DOBOTDLL_H

#include "DobotType.h"

#ifndef DOBOTDLLSHARED_EXPORT
#if defined(_WIN32)
#define DOBOTDLLSHARED_EXPORT __declspec(dllimport)
#else
#define DOBOTDLLSHARED_EXPORT
#endif
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Connection ---- */

/* Does nothing: there is no event loop to run. */
DOBOTDLLSHARED_EXPORT int DobotExec(void);
DOBOTDLLSHARED_EXPORT int PeriodicTask(void);

/* Where arms could be: names separated by one blank, as many as fit into maxLen bytes. Returns how many; list may be NULL. */
DOBOTDLLSHARED_EXPORT int SearchDobot(char *dobotNameList, uint32_t maxLen);

/*
 * Connects to the arm at a port: a serial port (COM3, /dev/ttyUSB0, ttyUSB0), an IPv4 address, "sim" for a virtual arm in
 * this process. NULL or "" is the environment's MAGICIAN_PORT, or else the first that SearchDobot finds. The environment's
 * MAGICIAN_PORT_COM3=sim sends a program that asks for COM3 elsewhere. baudrate: 115200 always.
 * fwType and version get "DobotSerial" and "0.0.0", or which other firmware answers; each may be NULL, or has room for 100.
 */
DOBOTDLLSHARED_EXPORT int ConnectDobot(const char *portName, uint32_t baudrate, char *fwType, char *version);

/* Ends the connection and leaves the arm as it is, its queue running. Always 0. */
DOBOTDLLSHARED_EXPORT int DisconnectDobot(void);

/* How long a function waits for an answer, ms; 3000 unless set. */
DOBOTDLLSHARED_EXPORT int SetCmdTimeout(uint32_t cmdTimeout);

/*
 * Why the last function that this thread called did not return 0: a sentence. Returns its length, and 0 if there is none;
 * writes as much as fits into size bytes, and a NUL. text may be NULL. Not in the vendor's library.
 */
DOBOTDLLSHARED_EXPORT int MagicianLastError(char *text, uint32_t size);

/* Lets [guarded] commands through: their names, separated by commas, or "all". Not in the vendor's library. */
DOBOTDLLSHARED_EXPORT int MagicianAllow(const char *names);

/* Does nothing: the environment's MAGICIAN_LOG=debug has the log say every call. */
DOBOTDLLSHARED_EXPORT int SetDebugEnable(bool isEnable);

/* ---- Device ---- */

/* [guarded] */
DOBOTDLLSHARED_EXPORT int SetDeviceSN(const char *deviceSN);
DOBOTDLLSHARED_EXPORT int GetDeviceSN(char *deviceSN, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetDeviceName(const char *deviceName);
DOBOTDLLSHARED_EXPORT int GetDeviceName(char *deviceName, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int GetDeviceVersion(uint8_t *majorVersion, uint8_t *minorVersion, uint8_t *revision);
/* Time since power-up, ms. */
DOBOTDLLSHARED_EXPORT int GetDeviceTime(uint32_t *deviceTime);
DOBOTDLLSHARED_EXPORT int GetDeviceInfo(DeviceCountInfo *deviceCountInfo);
/* [not this arm] */
DOBOTDLLSHARED_EXPORT int GetMarlinVersion(void);

/* Whether the arm stands on a rail. */
DOBOTDLLSHARED_EXPORT int SetDeviceWithL(bool isWithL, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetDeviceWithL(bool *isWithL);

/* ---- Pose ---- */

DOBOTDLLSHARED_EXPORT int GetPose(Pose *pose);
DOBOTDLLSHARED_EXPORT int GetPoseEx(Pose *pose);
/* [guarded] Takes the angles of rear arm and forearm from the sensors, or, with manual, those given; degrees. */
DOBOTDLLSHARED_EXPORT int ResetPose(bool manual, float rearArmAngle, float frontArmAngle);
DOBOTDLLSHARED_EXPORT int GetKinematics(Kinematics *kinematics);
/* Where the arm is on its rail, mm. */
DOBOTDLLSHARED_EXPORT int GetPoseL(float *l);

/* ---- Alarms ---- */

/* One bit an alarm, alarm n in byte n / 8; len gets how many bytes the arm has. */
DOBOTDLLSHARED_EXPORT int GetAlarmsState(uint8_t *alarmsState, uint32_t *len, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int ClearAllAlarmsState(void);

/* ---- Homing and levelling ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetHOMEParams(HOMEParams *homeParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetHOMEParams(HOMEParams *homeParams);
/* [always queued] Homes the arm: half a minute. */
DOBOTDLLSHARED_EXPORT int SetHOMECmd(HOMECmd *homeCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetAutoLevelingCmd(AutoLevelingCmd *autoLevelingCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetAutoLevelingResult(float *precision);

/* ---- Hand teaching ---- */

DOBOTDLLSHARED_EXPORT int SetHHTTrigMode(HHTTrigMode hhtTrigMode);
DOBOTDLLSHARED_EXPORT int GetHHTTrigMode(HHTTrigMode *hhtTrigMode);
DOBOTDLLSHARED_EXPORT int SetHHTTrigOutputEnabled(bool isEnabled);
DOBOTDLLSHARED_EXPORT int GetHHTTrigOutputEnabled(bool *isEnabled);
/* Whether a point has been taught since the last look. */
DOBOTDLLSHARED_EXPORT int GetHHTTrigOutput(bool *isTriggered);

/* ---- End effector ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorParams(EndEffectorParams *endEffectorParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorParams(EndEffectorParams *endEffectorParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorLaser(bool enableCtrl, bool on, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorLaser(bool *isCtrlEnabled, bool *isOn);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorSuctionCup(bool enableCtrl, bool suck, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorSuctionCup(bool *isCtrlEnabled, bool *isSucked);
/* [always queued] grip closes, without it opens; without enableCtrl the pump rests. */
DOBOTDLLSHARED_EXPORT int SetEndEffectorGripper(bool enableCtrl, bool grip, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorGripper(bool *isCtrlEnabled, bool *isGripped);

/* ---- Arm orientation ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetArmOrientation(ArmOrientation armOrientation, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetArmOrientation(ArmOrientation *armOrientation);

/* ---- Jog ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetJOGJointParams(JOGJointParams *jointJogParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGJointParams(JOGJointParams *jointJogParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetJOGCoordinateParams(JOGCoordinateParams *coordinateJogParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGCoordinateParams(JOGCoordinateParams *coordinateJogParams);
DOBOTDLLSHARED_EXPORT int SetJOGLParams(JOGLParams *jogLParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGLParams(JOGLParams *jogLParams);
DOBOTDLLSHARED_EXPORT int SetJOGCommonParams(JOGCommonParams *jogCommonParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGCommonParams(JOGCommonParams *jogCommonParams);
/* Moves until cmd is JogIdle; without isQueued, or the end comes late. */
DOBOTDLLSHARED_EXPORT int SetJOGCmd(JOGCmd *jogCmd, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Point to point ---- */

/* [always queued], all of them */
DOBOTDLLSHARED_EXPORT int SetPTPJointParams(PTPJointParams *ptpJointParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJointParams(PTPJointParams *ptpJointParams);
DOBOTDLLSHARED_EXPORT int SetPTPCoordinateParams(PTPCoordinateParams *ptpCoordinateParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPCoordinateParams(PTPCoordinateParams *ptpCoordinateParams);
DOBOTDLLSHARED_EXPORT int SetPTPLParams(PTPLParams *ptpLParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPLParams(PTPLParams *ptpLParams);
DOBOTDLLSHARED_EXPORT int SetPTPJumpParams(PTPJumpParams *ptpJumpParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJumpParams(PTPJumpParams *ptpJumpParams);
DOBOTDLLSHARED_EXPORT int SetPTPCommonParams(PTPCommonParams *ptpCommonParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPCommonParams(PTPCommonParams *ptpCommonParams);
DOBOTDLLSHARED_EXPORT int SetPTPCmd(PTPCmd *ptpCmd, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPWithLCmd(PTPWithLCmd *ptpWithLCmd, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPJump2Params(PTPJump2Params *ptpJump2Params, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJump2Params(PTPJump2Params *ptpJump2Params);
/* A move that switches outputs on the way. */
DOBOTDLLSHARED_EXPORT int SetPTPPOCmd(PTPCmd *ptpCmd, ParallelOutputCmd *parallelCmd, int parallelCmdCount,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPPOWithLCmd(PTPWithLCmd *ptpWithLCmd, ParallelOutputCmd *parallelCmd,
    int parallelCmdCount, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Continuous path ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPParams(CPParams *cpParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetCPParams(CPParams *cpParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPCmd(CPCmd *cpCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] With the laser's power. */
DOBOTDLLSHARED_EXPORT int SetCPLECmd(CPCmd *cpCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* Whether the tool keeps its rotation. */
DOBOTDLLSHARED_EXPORT int SetCPRHoldEnable(bool isEnable);
DOBOTDLLSHARED_EXPORT int GetCPRHoldEnable(bool *isEnable);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPCommonParams(CPCommonParams *cpCommonParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetCPCommonParams(CPCommonParams *cpCommonParams);

/* ---- Arcs and circles ---- */

/* [always queued], all of them */
DOBOTDLLSHARED_EXPORT int SetARCParams(ARCParams *arcParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetARCParams(ARCParams *arcParams);
DOBOTDLLSHARED_EXPORT int SetARCCmd(ARCCmd *arcCmd, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetCircleCmd(CircleCmd *circleCmd, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetARCCommonParams(ARCCommonParams *arcCommonParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetARCCommonParams(ARCCommonParams *arcCommonParams);

/* ---- Waiting ---- */

/* [always queued] The queue waits a time. */
DOBOTDLLSHARED_EXPORT int SetWAITCmd(WAITCmd *waitCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] The queue waits for an input. */
DOBOTDLLSHARED_EXPORT int SetTRIGCmd(TRIGCmd *trigCmd, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Inputs and outputs ---- */

/* [always queued], those with isQueued. A get reads from the structure what it is about: set address first. */
DOBOTDLLSHARED_EXPORT int SetIOMultiplexing(IOMultiplexing *ioMultiplexing, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIOMultiplexing(IOMultiplexing *ioMultiplexing);
DOBOTDLLSHARED_EXPORT int SetIODO(IODO *ioDO, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIODO(IODO *ioDO);
DOBOTDLLSHARED_EXPORT int SetIOPWM(IOPWM *ioPWM, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIOPWM(IOPWM *ioPWM);
DOBOTDLLSHARED_EXPORT int GetIODI(IODI *ioDI);
DOBOTDLLSHARED_EXPORT int GetIOADC(IOADC *ioADC);
DOBOTDLLSHARED_EXPORT int SetEMotor(EMotor *eMotor, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetEMotorS(EMotorS *eMotorS, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Sensors ---- */

DOBOTDLLSHARED_EXPORT int SetColorSensor(bool enable, ColorPort colorPort);
DOBOTDLLSHARED_EXPORT int GetColorSensor(uint8_t *r, uint8_t *g, uint8_t *b);
DOBOTDLLSHARED_EXPORT int SetInfraredSensor(bool enable, InfraredPort infraredPort);
DOBOTDLLSHARED_EXPORT int GetInfraredSensor(InfraredPort port, uint8_t *value);

/* ---- Calibration: kept in the arm ---- */

/* [guarded], all sets */
DOBOTDLLSHARED_EXPORT int SetAngleSensorStaticError(float rearArmAngleError, float frontArmAngleError);
DOBOTDLLSHARED_EXPORT int GetAngleSensorStaticError(float *rearArmAngleError, float *frontArmAngleError);
DOBOTDLLSHARED_EXPORT int SetAngleSensorCoef(float rearArmAngleCoef, float frontArmAngleCoef);
DOBOTDLLSHARED_EXPORT int GetAngleSensorCoef(float *rearArmAngleCoef, float *frontArmAngleCoef);
DOBOTDLLSHARED_EXPORT int SetBaseDecoderStaticError(float baseDecoderError);
DOBOTDLLSHARED_EXPORT int GetBaseDecoderStaticError(float *baseDecoderError);
/* [not this arm] */
DOBOTDLLSHARED_EXPORT int SetLRHandCalibrateValue(float lrHandCalibrateValue);
DOBOTDLLSHARED_EXPORT int GetLRHandCalibrateValue(float *lrHandCalibrateValue);

/* ---- Wi-Fi ---- */

/* [guarded], all sets */
DOBOTDLLSHARED_EXPORT int SetWIFIConfigMode(bool enable);
DOBOTDLLSHARED_EXPORT int GetWIFIConfigMode(bool *isEnabled);
DOBOTDLLSHARED_EXPORT int SetWIFISSID(const char *ssid);
DOBOTDLLSHARED_EXPORT int GetWIFISSID(char *ssid, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetWIFIPassword(const char *password);
DOBOTDLLSHARED_EXPORT int GetWIFIPassword(char *password, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetWIFIIPAddress(WIFIIPAddress *wifiIPAddress);
DOBOTDLLSHARED_EXPORT int GetWIFIIPAddress(WIFIIPAddress *wifiIPAddress);
DOBOTDLLSHARED_EXPORT int SetWIFINetmask(WIFINetmask *wifiNetmask);
DOBOTDLLSHARED_EXPORT int GetWIFINetmask(WIFINetmask *wifiNetmask);
DOBOTDLLSHARED_EXPORT int SetWIFIGateway(WIFIGateway *wifiGateway);
DOBOTDLLSHARED_EXPORT int GetWIFIGateway(WIFIGateway *wifiGateway);
DOBOTDLLSHARED_EXPORT int SetWIFIDNS(WIFIDNS *wifiDNS);
DOBOTDLLSHARED_EXPORT int GetWIFIDNS(WIFIDNS *wifiDNS);
DOBOTDLLSHARED_EXPORT int GetWIFIConnectStatus(bool *isConnected);

/* ---- Lost steps ---- */

/* How far a joint may be off before it counts as lost, degrees. */
DOBOTDLLSHARED_EXPORT int SetLostStepParams(float threshold, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] Compares the joints with their sensors. */
DOBOTDLLSHARED_EXPORT int SetLostStepCmd(bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Firmware, serial connector, tests ---- */

/* [guarded], the sets */
DOBOTDLLSHARED_EXPORT int UpdateFirmware(FirmwareParams *firmwareParams);
DOBOTDLLSHARED_EXPORT int SetFirmwareMode(FirmwareMode *firmwareMode);
DOBOTDLLSHARED_EXPORT int GetFirmwareMode(FirmwareMode *firmwareMode);
DOBOTDLLSHARED_EXPORT int GetUART4PeripheralsType(uint8_t *type);
DOBOTDLLSHARED_EXPORT int SetUART4PeripheralsEnable(bool isEnable);
DOBOTDLLSHARED_EXPORT int GetUART4PeripheralsEnable(bool *isEnable);
DOBOTDLLSHARED_EXPORT int SendPluse(PluseCmd *pluseCmd, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SendPluseEx(PluseCmd *pluseCmd);
DOBOTDLLSHARED_EXPORT int GetUserParams(UserParams *userParams);
/* How long a move would take, ms. */
DOBOTDLLSHARED_EXPORT int GetPTPTime(PTPCmd *ptpCmd, uint32_t *ptpTime);
/* [not this arm], all of these */
DOBOTDLLSHARED_EXPORT int GetServoPIDParams(PID *pid);
DOBOTDLLSHARED_EXPORT int SetServoPIDParams(PID *pid, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetServoControlLoop(uint8_t index, uint8_t *controlLoop);
DOBOTDLLSHARED_EXPORT int SetServoControlLoop(uint8_t index, uint8_t controlLoop, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SaveServoPIDParams(uint8_t index, uint8_t controlLoop, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Queue ---- */

DOBOTDLLSHARED_EXPORT int SetQueuedCmdStartExec(void);
/* Stops the queue when the running command has ended. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStopExec(void);
/* Stops the queue and the running command. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdForceStopExec(void);
/* [guarded] What is queued from here on becomes the program in the arm's memory: how often it runs, and of how many commands it is. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStartDownload(uint32_t totalLoop, uint32_t linePerLoop);
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStopDownload(void);
/* Drops what waits. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdClear(void);
/* Index of the command that ended last. */
DOBOTDLLSHARED_EXPORT int GetQueuedCmdCurrentIndex(uint64_t *queuedCmdCurrentIndex);
DOBOTDLLSHARED_EXPORT int GetQueuedCmdMotionFinish(bool *isFinish);

#ifdef __cplusplus
}
#endif

#endif
