/*
 * The vendor's C interface to the Dobot Magician, under the vendor's names.
 *
 * All functions about an arm begin with its dobotId, which ConnectDobot hands out. See DobotType.h for the structures
 * and what is returned.
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
 * dobotId gets the arm's id for all other functions.
 */
DOBOTDLLSHARED_EXPORT int ConnectDobot(const char *portName, uint32_t baudrate, char *fwType, char *version,
    int *dobotId);

/* Ends the connection and leaves the arm as it is, its queue running. Always 0. */
DOBOTDLLSHARED_EXPORT int DisconnectDobot(int dobotId);

/* How long a function waits for an answer, ms; 3000 unless set. */
DOBOTDLLSHARED_EXPORT int SetCmdTimeout(int dobotId, uint32_t cmdTimeout);

/*
 * Why the last function that this thread called did not return 0: a sentence. Returns its length, and 0 if there is none;
 * writes as much as fits into size bytes, and a NUL. text may be NULL. Not in the vendor's library.
 */
DOBOTDLLSHARED_EXPORT int MagicianLastError(char *text, uint32_t size);

/* Lets [guarded] commands through: their names, separated by commas, or "all". Not in the vendor's library. */
DOBOTDLLSHARED_EXPORT int MagicianAllow(const char *names);

/* ---- Device ---- */

/* [guarded] */
DOBOTDLLSHARED_EXPORT int SetDeviceSN(int dobotId, const char *deviceSN);
DOBOTDLLSHARED_EXPORT int GetDeviceSN(int dobotId, char *deviceSN, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetDeviceName(int dobotId, const char *deviceName);
DOBOTDLLSHARED_EXPORT int GetDeviceName(int dobotId, char *deviceName, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int GetDeviceVersion(int dobotId, uint8_t *majorVersion, uint8_t *minorVersion,
    uint8_t *revision);
/* Time since power-up, ms. */
DOBOTDLLSHARED_EXPORT int GetDeviceTime(int dobotId, uint32_t *deviceTime);

/* Whether the arm stands on a rail. */
DOBOTDLLSHARED_EXPORT int SetDeviceWithL(int dobotId, bool isWithL);
DOBOTDLLSHARED_EXPORT int GetDeviceWithL(int dobotId, bool *isWithL);

/* ---- Pose ---- */

DOBOTDLLSHARED_EXPORT int GetPose(int dobotId, Pose *pose);
DOBOTDLLSHARED_EXPORT int GetPoseEx(int dobotId, Pose *pose);
/* [guarded] Takes the angles of rear arm and forearm from the sensors, or, with manual, those given; degrees. */
DOBOTDLLSHARED_EXPORT int ResetPose(int dobotId, bool manual, float rearArmAngle, float frontArmAngle);
DOBOTDLLSHARED_EXPORT int GetKinematics(int dobotId, Kinematics *kinematics);
/* Where the arm is on its rail, mm. */
DOBOTDLLSHARED_EXPORT int GetPoseL(int dobotId, float *l);

/* ---- Alarms ---- */

/* One bit an alarm, alarm n in byte n / 8; len gets how many bytes the arm has. */
DOBOTDLLSHARED_EXPORT int GetAlarmsState(int dobotId, uint8_t *alarmsState, uint32_t *len, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int ClearAllAlarmsState(int dobotId);

/* ---- Homing and levelling ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetHOMEParams(int dobotId, HOMEParams *homeParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetHOMEParams(int dobotId, HOMEParams *homeParams);
/* [always queued] Homes the arm: half a minute. */
DOBOTDLLSHARED_EXPORT int SetHOMECmd(int dobotId, HOMECmd *homeCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetAutoLevelingCmd(int dobotId, AutoLevelingCmd *autoLevelingCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetAutoLevelingResult(int dobotId, float *precision);

/* ---- Hand teaching ---- */

DOBOTDLLSHARED_EXPORT int SetHHTTrigMode(int dobotId, HHTTrigMode hhtTrigMode);
DOBOTDLLSHARED_EXPORT int GetHHTTrigMode(int dobotId, HHTTrigMode *hhtTrigMode);
DOBOTDLLSHARED_EXPORT int SetHHTTrigOutputEnabled(int dobotId, bool isEnabled);
DOBOTDLLSHARED_EXPORT int GetHHTTrigOutputEnabled(int dobotId, bool *isEnabled);
/* Whether a point has been taught since the last look. */
DOBOTDLLSHARED_EXPORT int GetHHTTrigOutput(int dobotId, bool *isTriggered);

/* ---- End effector ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorParams(int dobotId, EndEffectorParams *endEffectorParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorParams(int dobotId, EndEffectorParams *endEffectorParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorLaser(int dobotId, bool enableCtrl, bool on, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorLaser(int dobotId, bool *isCtrlEnabled, bool *isOn);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetEndEffectorSuctionCup(int dobotId, bool enableCtrl, bool suck, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorSuctionCup(int dobotId, bool *isCtrlEnabled, bool *isSucked);
/* [always queued] grip closes, without it opens; without enableCtrl the pump rests. */
DOBOTDLLSHARED_EXPORT int SetEndEffectorGripper(int dobotId, bool enableCtrl, bool grip, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetEndEffectorGripper(int dobotId, bool *isCtrlEnabled, bool *isGripped);

/* ---- Arm orientation ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetArmOrientation(int dobotId, ArmOrientation armOrientation, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetArmOrientation(int dobotId, ArmOrientation *armOrientation);

/* ---- Jog ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetJOGJointParams(int dobotId, JOGJointParams *jointJogParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGJointParams(int dobotId, JOGJointParams *jointJogParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetJOGCoordinateParams(int dobotId, JOGCoordinateParams *coordinateJogParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGCoordinateParams(int dobotId, JOGCoordinateParams *coordinateJogParams);
DOBOTDLLSHARED_EXPORT int SetJOGLParams(int dobotId, JOGLParams *jogLParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGLParams(int dobotId, JOGLParams *jogLParams);
DOBOTDLLSHARED_EXPORT int SetJOGCommonParams(int dobotId, JOGCommonParams *jogCommonParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetJOGCommonParams(int dobotId, JOGCommonParams *jogCommonParams);
/* Moves until cmd is JogIdle; without isQueued, or the end comes late. */
DOBOTDLLSHARED_EXPORT int SetJOGCmd(int dobotId, JOGCmd *jogCmd, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Point to point ---- */

/* [always queued], all of them */
DOBOTDLLSHARED_EXPORT int SetPTPJointParams(int dobotId, PTPJointParams *ptpJointParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJointParams(int dobotId, PTPJointParams *ptpJointParams);
DOBOTDLLSHARED_EXPORT int SetPTPCoordinateParams(int dobotId, PTPCoordinateParams *ptpCoordinateParams,
    bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPCoordinateParams(int dobotId, PTPCoordinateParams *ptpCoordinateParams);
DOBOTDLLSHARED_EXPORT int SetPTPLParams(int dobotId, PTPLParams *ptpLParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPLParams(int dobotId, PTPLParams *ptpLParams);
DOBOTDLLSHARED_EXPORT int SetPTPJumpParams(int dobotId, PTPJumpParams *ptpJumpParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJumpParams(int dobotId, PTPJumpParams *ptpJumpParams);
DOBOTDLLSHARED_EXPORT int SetPTPCommonParams(int dobotId, PTPCommonParams *ptpCommonParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPCommonParams(int dobotId, PTPCommonParams *ptpCommonParams);
DOBOTDLLSHARED_EXPORT int SetPTPCmd(int dobotId, PTPCmd *ptpCmd, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPWithLCmd(int dobotId, PTPWithLCmd *ptpWithLCmd, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPJump2Params(int dobotId, PTPJump2Params *ptpJump2Params, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetPTPJump2Params(int dobotId, PTPJump2Params *ptpJump2Params);
/* A move that switches outputs on the way. */
DOBOTDLLSHARED_EXPORT int SetPTPPOCmd(int dobotId, PTPCmd *ptpCmd, ParallelOutputCmd *parallelCmd,
    int parallelCmdCount, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetPTPPOWithLCmd(int dobotId, PTPWithLCmd *ptpWithLCmd,
    ParallelOutputCmd *parallelCmd, int parallelCmdCount, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Continuous path ---- */

/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPParams(int dobotId, CPParams *cpParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetCPParams(int dobotId, CPParams *cpParams);
/* [always queued] */
DOBOTDLLSHARED_EXPORT int SetCPCmd(int dobotId, CPCmd *cpCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] With the laser's power. */
DOBOTDLLSHARED_EXPORT int SetCPLECmd(int dobotId, CPCmd *cpCmd, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Arcs and circles ---- */

/* [always queued], all of them */
DOBOTDLLSHARED_EXPORT int SetARCParams(int dobotId, ARCParams *arcParams, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetARCParams(int dobotId, ARCParams *arcParams);
DOBOTDLLSHARED_EXPORT int SetARCCmd(int dobotId, ARCCmd *arcCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* Once round: count is not looked at, for the Python modules of this family hand in none. */
DOBOTDLLSHARED_EXPORT int SetCircleCmd(int dobotId, CircleCmd *circleCmd, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Waiting ---- */

/* [always queued] The queue waits a time. */
DOBOTDLLSHARED_EXPORT int SetWAITCmd(int dobotId, WAITCmd *waitCmd, bool isQueued, uint64_t *queuedCmdIndex);
/* [always queued] The queue waits for an input. */
DOBOTDLLSHARED_EXPORT int SetTRIGCmd(int dobotId, TRIGCmd *trigCmd, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Inputs and outputs ---- */

/* [always queued], those with isQueued. A get reads from the structure what it is about: set address first. */
DOBOTDLLSHARED_EXPORT int SetIOMultiplexing(int dobotId, IOMultiplexing *ioMultiplexing, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIOMultiplexing(int dobotId, IOMultiplexing *ioMultiplexing);
DOBOTDLLSHARED_EXPORT int SetIODO(int dobotId, IODO *ioDO, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIODO(int dobotId, IODO *ioDO);
DOBOTDLLSHARED_EXPORT int SetIOPWM(int dobotId, IOPWM *ioPWM, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetIOPWM(int dobotId, IOPWM *ioPWM);
DOBOTDLLSHARED_EXPORT int GetIODI(int dobotId, IODI *ioDI);
DOBOTDLLSHARED_EXPORT int GetIOADC(int dobotId, IOADC *ioADC);
DOBOTDLLSHARED_EXPORT int SetEMotor(int dobotId, EMotor *eMotor, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SetEMotorS(int dobotId, EMotorS *eMotorS, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Sensors ---- */

DOBOTDLLSHARED_EXPORT int SetColorSensor(int dobotId, bool enable, ColorPort colorPort);
DOBOTDLLSHARED_EXPORT int GetColorSensor(int dobotId, uint8_t *r, uint8_t *g, uint8_t *b);
DOBOTDLLSHARED_EXPORT int SetInfraredSensor(int dobotId, bool enable, InfraredPort infraredPort);
DOBOTDLLSHARED_EXPORT int GetInfraredSensor(int dobotId, InfraredPort port, uint8_t *value);

/* ---- Calibration: kept in the arm ---- */

/* [guarded], all sets */
DOBOTDLLSHARED_EXPORT int SetAngleSensorStaticError(int dobotId, float rearArmAngleError,
    float frontArmAngleError);
DOBOTDLLSHARED_EXPORT int GetAngleSensorStaticError(int dobotId, float *rearArmAngleError,
    float *frontArmAngleError);
DOBOTDLLSHARED_EXPORT int SetAngleSensorCoef(int dobotId, float rearArmAngleCoef, float frontArmAngleCoef);
DOBOTDLLSHARED_EXPORT int GetAngleSensorCoef(int dobotId, float *rearArmAngleCoef, float *frontArmAngleCoef);
DOBOTDLLSHARED_EXPORT int SetBaseDecoderStaticError(int dobotId, float baseDecoderError);
DOBOTDLLSHARED_EXPORT int GetBaseDecoderStaticError(int dobotId, float *baseDecoderError);
/* [not this arm] */
DOBOTDLLSHARED_EXPORT int SetLRHandCalibrateValue(int dobotId, float lrHandCalibrateValue);
DOBOTDLLSHARED_EXPORT int GetLRHandCalibrateValue(int dobotId, float *lrHandCalibrateValue);

/* ---- Wi-Fi ---- */

/* [guarded], all sets */
DOBOTDLLSHARED_EXPORT int SetWIFIConfigMode(int dobotId, bool enable);
DOBOTDLLSHARED_EXPORT int GetWIFIConfigMode(int dobotId, bool *isEnabled);
DOBOTDLLSHARED_EXPORT int SetWIFISSID(int dobotId, const char *ssid);
DOBOTDLLSHARED_EXPORT int GetWIFISSID(int dobotId, char *ssid, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetWIFIPassword(int dobotId, const char *password);
DOBOTDLLSHARED_EXPORT int GetWIFIPassword(int dobotId, char *password, uint32_t maxLen);
DOBOTDLLSHARED_EXPORT int SetWIFIIPAddress(int dobotId, WIFIIPAddress *wifiIPAddress);
DOBOTDLLSHARED_EXPORT int GetWIFIIPAddress(int dobotId, WIFIIPAddress *wifiIPAddress);
DOBOTDLLSHARED_EXPORT int SetWIFINetmask(int dobotId, WIFINetmask *wifiNetmask);
DOBOTDLLSHARED_EXPORT int GetWIFINetmask(int dobotId, WIFINetmask *wifiNetmask);
DOBOTDLLSHARED_EXPORT int SetWIFIGateway(int dobotId, WIFIGateway *wifiGateway);
DOBOTDLLSHARED_EXPORT int GetWIFIGateway(int dobotId, WIFIGateway *wifiGateway);
DOBOTDLLSHARED_EXPORT int SetWIFIDNS(int dobotId, WIFIDNS *wifiDNS);
DOBOTDLLSHARED_EXPORT int GetWIFIDNS(int dobotId, WIFIDNS *wifiDNS);
DOBOTDLLSHARED_EXPORT int GetWIFIConnectStatus(int dobotId, bool *isConnected);

/* ---- Lost steps ---- */

/* How far a joint may be off before it counts as lost, degrees. */
DOBOTDLLSHARED_EXPORT int SetLostStepParams(int dobotId, float threshold);
/* [always queued] Compares the joints with their sensors. */
DOBOTDLLSHARED_EXPORT int SetLostStepCmd(int dobotId, bool isQueued, uint64_t *queuedCmdIndex);

/* ---- Firmware, serial connector, tests ---- */

/* [guarded], the sets */
DOBOTDLLSHARED_EXPORT int UpdateFirmware(int dobotId, FirmwareParams *firmwareParams);
DOBOTDLLSHARED_EXPORT int SetFirmwareMode(int dobotId, FirmwareMode *firmwareMode);
DOBOTDLLSHARED_EXPORT int GetFirmwareMode(int dobotId, FirmwareMode *firmwareMode);
DOBOTDLLSHARED_EXPORT int GetUserParams(int dobotId, UserParams *userParams);
/* How long a move would take, ms. */
DOBOTDLLSHARED_EXPORT int GetPTPTime(int dobotId, PTPCmd *ptpCmd, uint32_t *ptpTime);
/* [not this arm], all of these */
DOBOTDLLSHARED_EXPORT int GetServoPIDParams(int dobotId, PID *pid);
DOBOTDLLSHARED_EXPORT int SetServoPIDParams(int dobotId, PID *pid, bool isQueued, uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int GetServoControlLoop(int dobotId, uint8_t index, uint8_t *controlLoop);
DOBOTDLLSHARED_EXPORT int SetServoControlLoop(int dobotId, uint8_t index, uint8_t controlLoop, bool isQueued,
    uint64_t *queuedCmdIndex);
DOBOTDLLSHARED_EXPORT int SaveServoPIDParams(int dobotId, uint8_t index, uint8_t controlLoop, bool isQueued,
    uint64_t *queuedCmdIndex);

/* ---- Queue ---- */

DOBOTDLLSHARED_EXPORT int SetQueuedCmdStartExec(int dobotId);
/* Stops the queue when the running command has ended. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStopExec(int dobotId);
/* Stops the queue and the running command. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdForceStopExec(int dobotId);
/* [guarded] What is queued from here on becomes the program in the arm's memory: how often it runs, and of how many commands it is. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStartDownload(int dobotId, uint32_t totalLoop, uint32_t linePerLoop);
DOBOTDLLSHARED_EXPORT int SetQueuedCmdStopDownload(int dobotId);
/* Drops what waits. */
DOBOTDLLSHARED_EXPORT int SetQueuedCmdClear(int dobotId);
/* Index of the command that ended last. */
DOBOTDLLSHARED_EXPORT int GetQueuedCmdCurrentIndex(int dobotId, uint64_t *queuedCmdCurrentIndex);

#ifdef __cplusplus
}
#endif

#endif
