/*
 * The vendor's C interface to the Dobot Magician, under the vendor's names.
 *
 * All functions about an arm begin with masterId and slaveId, which ConnectDobot hands out. For an arm without a
 * controller box, slaveId is not looked at. See DobotType.h for the structures and what is returned.
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
 * info gets the ids for all other functions: masterDevInfo.devId, and 0 for the slave.
 */
DOBOTDLLSHARED_EXPORT int ConnectDobot(const char *portName, uint32_t baudrate, ConnectInfo *info);

/* Ends the connection and leaves the arm as it is, its queue running. Always 0. */
DOBOTDLLSHARED_EXPORT int DisconnectDobot(int masterId);

/* How long a function waits for an answer, ms; 3000 unless set. */
DOBOTDLLSHARED_EXPORT int SetCmdTimeout(int masterId, uint32_t cmdTimeout);

/*
 * Why the last function that this thread called did not return 0: a sentence. Returns its length, and 0 if there is none;
 * writes as much as fits into size bytes, and a NUL. text may be NULL. Not in the vendor's library.
 */
DOBOTDLLSHARED_EXPORT int MagicianLastError(char *text, uint32_t size);

/* Lets [guarded] commands through: their names, separated by commas, or "all". Not in the vendor's library. */
DOBOTDLLSHARED_EXPORT int MagicianAllow(const char *names);

/* Does nothing: the environment's MAGICIAN_LOG=debug has the log say every call. */
DOBOTDLLSHARED_EXPORT int SetDebugEnable(bool isEnable);

/* Waits. */
DOBOTDLLSHARED_EXPORT int DobotSleep(uint32_t milliseconds);

/* ---- Device ---- */

/* [guarded] */
DOBOTDLLSHARED_EXPORT int SetDeviceSN(int masterId, int slaveId, const char *deviceSN);
DOBOTDLLSHARED_EXPORT int GetDeviceSN(int masterId, int slaveId, char *deviceSN, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetDeviceName(int masterId, int slaveId, const char *deviceName);
DOBOTDLLSHARED_EXPORT int GetDeviceName(int masterId, int slaveId, char *deviceName, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int GetDeviceVersion(int masterId, int slaveId, DeviceVersion *deviceVersion);
/* Time since power-up, ms. */
DOBOTDLLSHARED_EXPORT int GetDeviceTime(int masterId, int slaveId, uint32_t *deviceTime);
DOBOTDLLSHARED_EXPORT int GetDeviceID(int masterId, int slaveId, DeviceID *deviceID);
DOBOTDLLSHARED_EXPORT int GetDeviceInfo(int masterId, int slaveId, DeviceCountInfo *deviceCountInfo);
/* [not this arm] */
DOBOTDLLSHARED_EXPORT int GetMarlinVersion(int masterId, int slaveId);

/* Whether the arm stands on a rail. */
DOBOTDLLSHARED_EXPORT int SetDeviceWithL(int masterId, int slaveId, bool isWithL, uint8_t version,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetDeviceWithL(int masterId, int slaveId, bool *isWithL);

/* ---- Pose ---- */

DOBOTDLLSHARED_EXPORT int GetPose(int masterId, int slaveId, Pose *pose);
/* [guarded] Takes the angles of rear arm and forearm from the sensors, or, with manual, those given; degrees. */
DOBOTDLLSHARED_EXPORT int ResetPose(int masterId, int slaveId, bool manual, float rearArmAngle,
    float frontArmAngle);
DOBOTDLLSHARED_EXPORT int GetKinematics(int masterId, int slaveId, Kinematics *kinematics);
/* Where the arm is on its rail, mm. */
DOBOTDLLSHARED_EXPORT int GetPoseL(int masterId, int slaveId, float *l);

/* ---- Alarms ---- */

/* One bit an alarm, alarm n in byte n / 8; len gets how many bytes the arm has. */
DOBOTDLLSHARED_EXPORT int GetAlarmsState(int masterId, int slaveId, uint8_t *alarmsState, uint32_t *len,
    uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int ClearAllAlarmsState(int masterId, int slaveId);

/* ---- Homing and levelling ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetHOMEParams(int masterId, int slaveId, HOMEParams *homeParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetHOMEParams(int masterId, int slaveId, HOMEParams *homeParams);
/* [always queued] Homes the arm: half a minute. */
DOBOTDLLSHARED_EXPORT int SetHOMECmd(int masterId, int slaveId, HOMECmd *homeCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetAutoLevelingCmd(int masterId, int slaveId, AutoLevelingCmd *autoLevelingCmd,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetAutoLevelingResult(int masterId, int slaveId, float *precision);

/* ---- Hand teaching ---- */

DOBOTDLLSHARED_EXPORT int SetHHTTrigMode(int masterId, int slaveId, HHTTrigMode hhtTrigMode);
DOBOTDLLSHARED_EXPORT int GetHHTTrigMode(int masterId, int slaveId, HHTTrigMode *hhtTrigMode);
DOBOTDLLSHARED_EXPORT int SetHHTTrigOutputEnabled(int masterId, int slaveId, bool isEnabled);
DOBOTDLLSHARED_EXPORT int GetHHTTrigOutputEnabled(int masterId, int slaveId, bool *isEnabled);
/* Whether a point has been taught since the last look. */
DOBOTDLLSHARED_EXPORT int GetHHTTrigOutput(int masterId, int slaveId, bool *isTriggered);

/* ---- End effector ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorParams(int masterId, int slaveId,
    EndEffectorParams *endEffectorParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorParams(int masterId, int slaveId,
    EndEffectorParams *endEffectorParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorLaser(int masterId, int slaveId, bool enableCtrl, bool on,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorLaser(int masterId, int slaveId, bool *isCtrlEnabled, bool *isOn);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorSuctionCup(int masterId, int slaveId, bool enableCtrl, bool suck,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorSuctionCup(int masterId, int slaveId, bool *isCtrlEnabled,
    bool *isSucked);
/* [always queued] grip closes, without it opens; without enableCtrl the pump rests. */
DOBOTDLLSHARED_EXPORT int SetEndEffectorGripper(int masterId, int slaveId, bool enableCtrl, bool grip,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorGripper(int masterId, int slaveId, bool *isCtrlEnabled,
    bool *isGripped);
/* [not this arm] isQueued comes first. */
DOBOTDLLSHARED_EXPORT int SetEndEffectorType(int masterId, int slaveId, bool isQueued, uint8_t endType,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorType(int masterId, int slaveId, uint8_t *endType);

/* ---- Arm orientation ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetArmOrientation(int masterId, int slaveId, ArmOrientation armOrientation,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetArmOrientation(int masterId, int slaveId, ArmOrientation *armOrientation);

/* ---- Jog ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetJOGJointParams(int masterId, int slaveId, JOGJointParams *jointJogParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGJointParams(int masterId, int slaveId, JOGJointParams *jointJogParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetJOGCoordinateParams(int masterId, int slaveId,
    JOGCoordinateParams *coordinateJogParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGCoordinateParams(int masterId, int slaveId,
    JOGCoordinateParams *coordinateJogParams);
DOBOTDLLSHARED_EXPORT int SetJOGLParams(int masterId, int slaveId, JOGLParams *jogLParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGLParams(int masterId, int slaveId, JOGLParams *jogLParams);
DOBOTDLLSHARED_EXPORT int SetJOGCommonParams(int masterId, int slaveId, JOGCommonParams *jogCommonParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGCommonParams(int masterId, int slaveId, JOGCommonParams *jogCommonParams);
/* Moves until cmd is JogIdle; without isQueued, or the end comes late. */
DOBOTDLLSHARED_EXPORT int SetJOGCmd(int masterId, int slaveId, JOGCmd *jogCmd, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Point to point ---- */

/* [always queued], all of them */
DOBOTDLLSHARED_EXPORT int SetPTPJointParams(int masterId, int slaveId, PTPJointParams *ptpJointParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJointParams(int masterId, int slaveId, PTPJointParams *ptpJointParams);
DOBOTDLLSHARED_EXPORT int SetPTPCoordinateParams(int masterId, int slaveId,
    PTPCoordinateParams *ptpCoordinateParams, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPCoordinateParams(int masterId, int slaveId,
    PTPCoordinateParams *ptpCoordinateParams);
DOBOTDLLSHARED_EXPORT int SetPTPLParams(int masterId, int slaveId, PTPLParams *ptpLParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPLParams(int masterId, int slaveId, PTPLParams *ptpLParams);
DOBOTDLLSHARED_EXPORT int SetPTPJumpParams(int masterId, int slaveId, PTPJumpParams *ptpJumpParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJumpParams(int masterId, int slaveId, PTPJumpParams *ptpJumpParams);
DOBOTDLLSHARED_EXPORT int SetPTPCommonParams(int masterId, int slaveId, PTPCommonParams *ptpCommonParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPCommonParams(int masterId, int slaveId, PTPCommonParams *ptpCommonParams);
DOBOTDLLSHARED_EXPORT int SetPTPCmd(int masterId, int slaveId, PTPCmd *ptpCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPWithLCmd(int masterId, int slaveId, PTPWithLCmd *ptpWithLCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPJump2Params(int masterId, int slaveId, PTPJump2Params *ptpJump2Params,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJump2Params(int masterId, int slaveId, PTPJump2Params *ptpJump2Params);
/* A move that switches outputs on the way. */
DOBOTDLLSHARED_EXPORT int SetPTPPOCmd(int masterId, int slaveId, PTPCmd *ptpCmd,
    ParallelOutputCmd *parallelCmd, int parallelCmdCount, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPPOWithLCmd(int masterId, int slaveId, PTPWithLCmd *ptpWithLCmd,
    ParallelOutputCmd *parallelCmd, int parallelCmdCount, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Continuous path ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPParams(int masterId, int slaveId, CPParams *cpParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetCPParams(int masterId, int slaveId, CPParams *cpParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPCmd(int masterId, int slaveId, CPCmd *cpCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
/* [always queued] With the laser's power. */
DOBOTDLLSHARED_EXPORT int SetCPLECmd(int masterId, int slaveId, CPCmd *cpCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetCP2Cmd(int masterId, int slaveId, CP2Cmd *cp2Cmd, bool isQueued,
    uint64_t *queuedCmdIndex);
/* Whether the tool keeps its rotation. */
DOBOTDLLSHARED_EXPORT int SetCPRHoldEnable(int masterId, int slaveId, bool isEnable);
DOBOTDLLSHARED_EXPORT int GetCPRHoldEnable(int masterId, int slaveId, bool *isEnable);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPCommonParams(int masterId, int slaveId, CPCommonParams *cpCommonParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetCPCommonParams(int masterId, int slaveId, CPCommonParams *cpCommonParams);

/* ---- Arcs and circles ---- */

/* [always queued], all of them */
DOBOTDLLSHARED_EXPORT int SetARCParams(int masterId, int slaveId, ARCParams *arcParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetARCParams(int masterId, int slaveId, ARCParams *arcParams);
DOBOTDLLSHARED_EXPORT int SetARCCmd(int masterId, int slaveId, ARCCmd *arcCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
/* Once round: count is not looked at, for the Python modules of this family hand in none. */
DOBOTDLLSHARED_EXPORT int SetCircleCmd(int masterId, int slaveId, CircleCmd *circleCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetARCCommonParams(int masterId, int slaveId, ARCCommonParams *arcCommonParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetARCCommonParams(int masterId, int slaveId, ARCCommonParams *arcCommonParams);

/* ---- Waiting ---- */

/* [always queued] The queue waits a time. */
DOBOTDLLSHARED_EXPORT int SetWAITCmd(int masterId, int slaveId, WAITCmd *waitCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
/* [always queued] The queue waits for an input. */
DOBOTDLLSHARED_EXPORT int SetTRIGCmd(int masterId, int slaveId, TRIGCmd *trigCmd, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Inputs and outputs ---- */

/* [always queued], those with isQueued. A get reads from the structure what it is about: set address first. */
DOBOTDLLSHARED_EXPORT int SetIOMultiplexing(int masterId, int slaveId, IOMultiplexing *ioMultiplexing,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIOMultiplexing(int masterId, int slaveId, IOMultiplexing *ioMultiplexing);
DOBOTDLLSHARED_EXPORT int SetIODO(int masterId, int slaveId, IODO *ioDO, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIODO(int masterId, int slaveId, IODO *ioDO);
DOBOTDLLSHARED_EXPORT int SetIOPWM(int masterId, int slaveId, IOPWM *ioPWM, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIOPWM(int masterId, int slaveId, IOPWM *ioPWM);
DOBOTDLLSHARED_EXPORT int GetIODI(int masterId, int slaveId, IODI *ioDI);
DOBOTDLLSHARED_EXPORT int GetIOADC(int masterId, int slaveId, IOADC *ioADC);
DOBOTDLLSHARED_EXPORT int SetEMotor(int masterId, int slaveId, EMotor *eMotor, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetEMotorS(int masterId, int slaveId, EMotorS *eMotorS, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Sensors ---- */

DOBOTDLLSHARED_EXPORT int SetColorSensor(int masterId, int slaveId, bool enable, uint8_t port,
    uint8_t version, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetColorSensor(int masterId, int slaveId, uint8_t *r, uint8_t *g, uint8_t *b);
DOBOTDLLSHARED_EXPORT int SetInfraredSensor(int masterId, int slaveId, bool enable, uint8_t port,
    uint8_t version, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetInfraredSensor(int masterId, int slaveId, InfraredPort port, uint8_t *value);

/* [not this arm], all of these */
DOBOTDLLSHARED_EXPORT int SetSeeedColorSensor(int masterId, int slaveId, uint8_t port, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetSeeedColorSensor(int masterId, int slaveId, uint16_t *r, uint16_t *g,
    uint16_t *b, uint16_t *cct);
DOBOTDLLSHARED_EXPORT int SetSeeedTempSensor(int masterId, int slaveId, uint8_t port, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetSeeedTempSensor(int masterId, int slaveId, uint16_t *temperature,
    uint16_t *humidity);
DOBOTDLLSHARED_EXPORT int SetSeeedLightSensor(int masterId, int slaveId, uint8_t port, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetSeeedLightSensor(int masterId, int slaveId, uint16_t *lux);
DOBOTDLLSHARED_EXPORT int GetSeeedDistanceSensor(int masterId, int slaveId, uint8_t port, uint8_t *distance);
DOBOTDLLSHARED_EXPORT int SetSeeedRgb(int masterId, int slaveId, uint8_t port, float rgb, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Calibration: kept in the arm ---- */

/* [guarded], all sets */
DOBOTDLLSHARED_EXPORT int SetAngleSensorStaticError(int masterId, int slaveId, float rearArmAngleError,
    float frontArmAngleError);
DOBOTDLLSHARED_EXPORT int GetAngleSensorStaticError(int masterId, int slaveId, float *rearArmAngleError,
    float *frontArmAngleError);
DOBOTDLLSHARED_EXPORT int SetAngleSensorCoef(int masterId, int slaveId, float rearArmAngleCoef,
    float frontArmAngleCoef);
DOBOTDLLSHARED_EXPORT int GetAngleSensorCoef(int masterId, int slaveId, float *rearArmAngleCoef,
    float *frontArmAngleCoef);
DOBOTDLLSHARED_EXPORT int SetBaseDecoderStaticError(int masterId, int slaveId, float baseDecoderError);
DOBOTDLLSHARED_EXPORT int GetBaseDecoderStaticError(int masterId, int slaveId, float *baseDecoderError);
/* [not this arm] */
DOBOTDLLSHARED_EXPORT int SetLRHandCalibrateValue(int masterId, int slaveId, float lrHandCalibrateValue);
DOBOTDLLSHARED_EXPORT int GetLRHandCalibrateValue(int masterId, int slaveId, float *lrHandCalibrateValue);

/* ---- Wi-Fi ---- */

/* [guarded], all sets */
DOBOTDLLSHARED_EXPORT int SetWIFIConfigMode(int masterId, int slaveId, bool enable);
DOBOTDLLSHARED_EXPORT int GetWIFIConfigMode(int masterId, int slaveId, bool *isEnabled);
DOBOTDLLSHARED_EXPORT int SetWIFISSID(int masterId, int slaveId, const char *ssid);
DOBOTDLLSHARED_EXPORT int GetWIFISSID(int masterId, int slaveId, char *ssid, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetWIFIPassword(int masterId, int slaveId, const char *password);
DOBOTDLLSHARED_EXPORT int GetWIFIPassword(int masterId, int slaveId, char *password, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetWIFIIPAddress(int masterId, int slaveId, WIFIIPAddress *wifiIPAddress);
DOBOTDLLSHARED_EXPORT int GetWIFIIPAddress(int masterId, int slaveId, WIFIIPAddress *wifiIPAddress);
DOBOTDLLSHARED_EXPORT int SetWIFINetmask(int masterId, int slaveId, WIFINetmask *wifiNetmask);
DOBOTDLLSHARED_EXPORT int GetWIFINetmask(int masterId, int slaveId, WIFINetmask *wifiNetmask);
DOBOTDLLSHARED_EXPORT int SetWIFIGateway(int masterId, int slaveId, WIFIGateway *wifiGateway);
DOBOTDLLSHARED_EXPORT int GetWIFIGateway(int masterId, int slaveId, WIFIGateway *wifiGateway);
DOBOTDLLSHARED_EXPORT int SetWIFIDNS(int masterId, int slaveId, WIFIDNS *wifiDNS);
DOBOTDLLSHARED_EXPORT int GetWIFIDNS(int masterId, int slaveId, WIFIDNS *wifiDNS);
DOBOTDLLSHARED_EXPORT int GetWIFIConnectStatus(int masterId, int slaveId, bool *isConnected);

/* ---- Lost steps ---- */

/* How far a joint may be off before it counts as lost, degrees. */
DOBOTDLLSHARED_EXPORT int SetLostStepParams(int masterId, int slaveId, float threshold, bool isQueued,
    uint64_t *queuedCmdIndex);
/* [always queued] Compares the joints with their sensors. */
DOBOTDLLSHARED_EXPORT int SetLostStepCmd(int masterId, int slaveId, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetLostStepEnableAndParamsCmd(int masterId, int slaveId, uint8_t enable,
    float threshold, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetLostStepEnableAndParamsCmd(int masterId, int slaveId, uint8_t *enable,
    float *threshold);

/* ---- Firmware, serial connector, tests ---- */

/* [guarded], the sets */
DOBOTDLLSHARED_EXPORT int UpdateFirmware(int masterId, int slaveId, FirmwareParams *firmwareParams);
DOBOTDLLSHARED_EXPORT int SetFirmwareMode(int masterId, int slaveId, FirmwareMode *firmwareMode);
DOBOTDLLSHARED_EXPORT int GetFirmwareMode(int masterId, int slaveId, FirmwareMode *firmwareMode);
/* [not this arm] */
DOBOTDLLSHARED_EXPORT int SetUpgradeFWReadyCmd(int masterId, int slaveId,
    UpgradeFWReadyCmd *upgradeFWReadyCmd);
DOBOTDLLSHARED_EXPORT int GetUpgradeFWReadyCmd(int masterId, int slaveId,
    UpgradeFWReadyCmd *upgradeFWReadyCmd, uint8_t *isReady);
DOBOTDLLSHARED_EXPORT int GetUART4PeripheralsType(int masterId, int slaveId, uint8_t *type);
DOBOTDLLSHARED_EXPORT int SetUART4PeripheralsEnable(int masterId, int slaveId, bool isEnable);
DOBOTDLLSHARED_EXPORT int GetUART4PeripheralsEnable(int masterId, int slaveId, bool *isEnable);
DOBOTDLLSHARED_EXPORT int SendPluse(int masterId, int slaveId, PluseCmd *pluseCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SendPluseEx(int masterId, int slaveId, PluseCmd *pluseCmd);
DOBOTDLLSHARED_EXPORT int GetUserParams(int masterId, int slaveId, UserParams *userParams);
/* How long a move would take, ms. */
DOBOTDLLSHARED_EXPORT int GetPTPTime(int masterId, int slaveId, PTPCmd *ptpCmd, uint32_t *ptpTime);

/* ---- Other machines: [not this arm], all of these; isQueued comes first where there is a value ---- */

DOBOTDLLSHARED_EXPORT int SetServoAngle(int masterId, int slaveId, bool isQueued, uint8_t servoId,
    float angle, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetServoAngle(int masterId, int slaveId, uint8_t servoId, float *angle);
DOBOTDLLSHARED_EXPORT int SetArmSpeedRatio(int masterId, int slaveId, bool isQueued, uint8_t paramsMode,
    uint8_t speedRatio, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetArmSpeedRatio(int masterId, int slaveId, uint8_t paramsMode,
    uint8_t *speedRatio);
DOBOTDLLSHARED_EXPORT int SetLSpeedRatio(int masterId, int slaveId, bool isQueued, uint8_t paramsMode,
    uint8_t speedRatio, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetLSpeedRatio(int masterId, int slaveId, uint8_t paramsMode, uint8_t *speedRatio);
DOBOTDLLSHARED_EXPORT int SetMotorMode(int masterId, int slaveId, int mode);
DOBOTDLLSHARED_EXPORT int GetMotorMode(int masterId, int slaveId, int *mode);
DOBOTDLLSHARED_EXPORT int SetProgbar(int masterId, int slaveId, uint8_t progbar);
DOBOTDLLSHARED_EXPORT int RestartMagicBox(int masterId, int slaveId);
DOBOTDLLSHARED_EXPORT int PrintInfo(int masterId, int slaveId, const char *info);
DOBOTDLLSHARED_EXPORT int GetDobotDHParams(int masterId, int slaveId);

/* ---- Queue ---- */

DOBOTDLLSHARED_EXPORT int SetQueuedCmdStartExec(int masterId, int slaveId);
/* Stops the queue when the running command has ended. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStopExec(int masterId, int slaveId);
/* Stops the queue and the running command. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdForceStopExec(int masterId, int slaveId);
/* [guarded] What is queued from here on becomes the program in the arm's memory: how often it runs, and of how many commands it is. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStartDownload(int masterId, int slaveId, uint32_t totalLoop,
    uint32_t linePerLoop);
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStopDownload(int masterId, int slaveId);
/* Drops what waits. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdClear(int masterId, int slaveId);
/* Index of the command that ended last. */
DOBOTDLLSHARED_EXPORT int GetQueuedCmdCurrentIndex(int masterId, int slaveId,
    uint64_t *queuedCmdCurrentIndex);
DOBOTDLLSHARED_EXPORT int GetQueuedCmdMotionFinish(int masterId, int slaveId, bool *isFinish);

#ifdef __cplusplus
}
#endif

#endif
